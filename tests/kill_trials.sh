#!/usr/bin/env bash
# kill_trials.sh N [PROGRAM]: kills `borelli run` N times with SIGKILL, at moments spread evenly over its stages, and
# starts the same command again. Every output must then equal that of an undisturbed run, byte for byte. Only times and
# memory in run.json and in the report may differ.
set -euo pipefail
count=${1:?how many trials}
program=$(realpath "${2:-build/release/borelli}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

"$program" phantom -o scan.nii.gz --spacing 10 >phantom.log 2>&1
arguments=(run scan.nii.gz --quantity hu --work-grid 6 --flight-time 0.5 --mesh-tolerance-mm 5)

# run.json or a report without times, memory, and the digest and sizes of these two files
plain() {
  tr -d '\n ' <"$1" | sed -E 's/"(seconds|peak_memory_mib|share)":[-+.e0-9]+/"\1"/g; s/"slowest":\[[^]]*\]//
                              s/"report.html":("[0-9a-f]*"|[0-9]+)//g; s/"bytes":[0-9]+,"path":"run.json"//'
}

"$program" "${arguments[@]}" --output whole >whole.log 2>&1
mapfile -t stages < <(sed -nE 's/^ *"stage": "(.*)",?$/\1/p' whole/scan/run.json | awk '!seen[$0]++')
declare -A seconds
while read -r stage took; do seconds[$stage]=$took; done < <(
  tr -d '\n ' <whole/scan/run.json | grep -oE '"seconds":[.e0-9-]+,"settings":|"stage":"[a-z]+"' |
    sed -E 's/"seconds":([.e0-9-]+),.*/\1/; s/"stage":"(.*)"/\1/' | awk '/^[a-z]+$/ { if (t) print $1, t; t = "" } /^[0-9]/ { t = $1 }')

recovered=0 ended=0
declare -A kills
for ((n = 0; n < count; ++n)); do
  stage=${stages[n % ${#stages[@]}]}
  rounds=$(((count + ${#stages[@]} - 1) / ${#stages[@]}))
  pause=$(awk -v n=$((n / ${#stages[@]})) -v rounds=$rounds -v s="${seconds[$stage]:-0}" 'BEGIN { print s * (n + 0.5) / rounds }')
  rm -rf out
  "$program" "${arguments[@]}" --output out >killed.log 2>&1 &
  run=$!
  until grep -q "^$stage " killed.log 2>/dev/null || ! kill -0 $run 2>/dev/null; do sleep 0.005; done
  sleep "$pause"
  if kill -KILL $run 2>/dev/null; then kills[$stage]=$((${kills[$stage]:-0} + 1)); else ended=$((ended + 1)); fi
  wait $run 2>/dev/null || true

  if ! "$program" "${arguments[@]}" --output out >resumed.log 2>&1; then
    echo "trial $n, killed in $stage after $pause s: the second run failed:" && cat resumed.log && continue
  fi
  if differs=$(diff -rq --exclude run.json --exclude report.html whole out 2>&1) &&
    cmp -s <(plain whole/scan/run.json) <(plain out/scan/run.json) &&
    cmp -s <(plain whole/scan/report.html) <(plain out/scan/report.html); then
    recovered=$((recovered + 1))
  else
    echo "trial $n, killed in $stage after $pause s: ${differs:-run.json or report.html} differ"
  fi
done
for stage in "${stages[@]}"; do printf '%-14s %6.2f s  killed %d times\n' "$stage" "${seconds[$stage]:-0}" "${kills[$stage]:-0}"; done
echo "$recovered of $count recovered byte for byte; $ended ended before the signal"
[ "$recovered" = "$count" ] && [ "$ended" -lt "$count" ]  # without a kill nothing was tried
