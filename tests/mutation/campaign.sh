#!/usr/bin/env bash
# A long campaign over all readers: N mutations of each, then coverage-guided fuzzing, and a table of both.
#   campaign.sh FOLDER [RUNS [MINUTES [JOBS [READER...]]]]      defaults: 100000 mutations, 10 minutes, 1 job, all readers
# FOLDER gets failures/ (cases), corpus/READER (libFuzzer's, kept for the next campaign), logs/ and table.md. Each reader
# fuzzes for MINUTES of processor time. Needs build/release/mutation and build/fuzz/fuzz (cmake --preset fuzz; cmake --build --preset fuzz).
set -euo pipefail
[ $# -ge 1 ] || { sed -n 2,5p "$0" >&2; exit 2; }
root=$(cd "$(dirname "$0")/../.." && pwd)
mutation=$root/build/release/mutation fuzz=$root/build/fuzz/fuzz
mkdir -p "$1"/{failures,corpus,logs,artifacts,rows}
out=$(cd "$1" && pwd) runs=${2:-100000} minutes=${3:-10} jobs=${4:-1}
readers=("${@:5}")
[ ${#readers[@]} -gt 0 ] || mapfile -t readers < <("$mutation" --list)

# libFuzzer ends at the first fault: start it again until the processor time is over
fuzz_reader() {  # reader
  local corpus=$out/corpus/$1 log=$out/logs/$1.fuzz left=$((60 * minutes)) spent
  mkdir -p "$corpus" "$out/artifacts/$1"
  "$mutation" "$1" --seeds "$corpus"
  : >"$log"
  TIMEFORMAT='%U %S'
  while [ "$left" -gt 5 ]; do
    spent=$({ time ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=0:handle_abort=1 "$fuzz" "--reader=$1" "$corpus" \
      -max_total_time="$left" -timeout=10 -rss_limit_mb=4096 -max_len=65536 -print_final_stats=1 \
      -artifact_prefix="$out/artifacts/$1/" >>"$log" 2>&1; } 2>&1) || true
    left=$(awk -v left="$left" '{print int(left - $1 - $2 - 1)}' <<<"$spent")
  done
}

campaign() {  # reader
  local line fuzzed="-" coverage="- | -" faults="-"
  nice -n 19 "$mutation" "$1" --runs "$runs" --failures "$out/failures" >"$out/logs/$1.mutation" 2>&1 || true
  line=$(grep -m1 " mutations of " "$out/logs/$1.mutation" || echo "$1: no answer")
  if [ -x "$fuzz" ] && [ "$minutes" -gt 0 ]; then
    nice -n 19 bash -c "$(declare -f fuzz_reader); out='$out' mutation='$mutation' fuzz='$fuzz' minutes='$minutes'; fuzz_reader $1"
    fuzzed=$(awk '/number_of_executed_units/ {n += $2} END {print n + 0}' "$out/logs/$1.fuzz")
    coverage=$(sed -nE 's/.* cov: ([0-9]+) ft: ([0-9]+).*/\1 | \2/p' "$out/logs/$1.fuzz" | tail -n 1)
    faults=$(find "$out/artifacts/$1" -type f | wc -l)
  fi
  sed -E "s/^([a-z0-9_]+): ([0-9]+) mutations .* in ([0-9.]+) s .* ([0-9]+) failed.*/| \1 | \2 | \3 | \4/" <<<"$line" |
    sed "s#\$# | $fuzzed | $((60 * minutes)) | $coverage | $faults |#" >"$out/rows/$1"
}

for reader in "${readers[@]}"; do
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n || true; done
  campaign "$reader" &
done
wait
{
  echo "| reader | mutations | s | failed | fuzz runs | fuzz s | edges | features | faults |"
  echo "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
  for reader in "${readers[@]}"; do cat "$out/rows/$reader"; done
} | tee "$out/table.md"
