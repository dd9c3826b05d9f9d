#!/usr/bin/env bash
# Whether two builds of the program give the same answers: files byte for byte, JSON answers without times.
#   same_answers.sh OLD_PROGRAM NEW_PROGRAM [FOLDER]
# Runs the sample phantom, the ICRP male, every scene of samples/, `evaluate` on the models of ../shared, and `chart` on
# three scenes. FOLDER (default: a temporary one) gets old/ and new/. Ends with 1 and the names of what differs.
# Files missing from ../shared are skipped with a message.
set -euo pipefail
[ $# -ge 2 ] || { sed -n 2,6p "$0" >&2; exit 2; }
old=$(realpath "$1") new=$(realpath "$2")
root=$(cd "$(dirname "$0")/.." && pwd)
if [ $# -gt 2 ]; then mkdir -p "$3"; out=$(cd "$3" && pwd); else out=$(mktemp -d); trap 'rm -rf "$out"' EXIT; fi
x=(); [ -n "${DISPLAY:-}" ] || ! command -v xvfb-run >/dev/null || x=(xvfb-run -a)  # for programs before 0.2.0

# A JSON answer without values that differ from run to run: times, memory, processor shares.
without_times() {
  python3 -c '
import json, sys
def kept(x):
    if isinstance(x, dict):
        return {k: kept(v) for k, v in x.items() if not any(w in k for w in ("seconds", "memory", "cost", "time_share"))}
    return [kept(v) for v in x] if isinstance(x, list) else x
try:
    print(json.dumps(kept(json.load(sys.stdin)), indent=1, sort_keys=True))
except ValueError:
    print("no JSON answer")'
}

answer() {  # FILE WORDS...: the program's answer, its exit code and what it says on standard error
  local file=$1 code=0
  shift
  mkdir -p "$(dirname "$file")"
  timeout 100 "$program" "$@" --json >"$file.raw" 2>"$file.err" || code=$?
  { without_times <"$file.raw"; echo "exit code $code"; grep -v ' s$\|%' "$file.err" || true; } >"$file"
  rm -f "$file.raw" "$file.err"
}

run_body() {  # NAME VOLUME WORDS...: a whole run; keeps the files that hold no times
  local name=$1 volume=$2 file
  shift 2
  "${x[@]}" "$program" run "$volume" -o "runs/$name" "$@" >/dev/null 2>&1 || echo "run $name ended with $?" >>runs.txt
  find "runs/$name" -type f \( -name '*.html' -o -name run.json -o -name '*.png' -o -name settings.toml \) -delete
}

all_answers() {
  local scene model name
  "$program" phantom --spacing 4 --noise 20 -o phantom.nii.gz >/dev/null
  run_body phantom phantom.nii.gz --sex male --pose standing
  if [ -d "$root/../shared" ]; then
    run_body male "$root/../shared/volumes/icrp_am/AM_hu.nii.gz" --quantity hu --sex male
    while read -r model; do
      answer "evaluate/${model//\//_}.json" evaluate "$root/../shared/models/$model"
    done < <(cd "$root/../shared/models" && find . \( -name '*.xml' -o -name '*.urdf' \) | sed 's#^[.]/##' | sort)
  else
    echo "no ../shared: the male and foreign models are left out" >&2
  fi
  for scene in "$root"/samples/*.toml "$root"/samples/gallery/*.toml; do
    [ -e "$scene" ] || continue
    name=$(basename "$scene" .toml)
    answer "scenes/$name.json" simulate "$scene" -o "scenes/$name.csv"
  done
  for scene in pendulum four_bar_2 heavy_top; do
    answer "charts/$scene.json" chart "$root/samples/$scene.toml" --end 0.5 --repeats 1 -o "charts/$scene"
    cut -d, -f1-6,8-14 "charts/$scene/chart.csv" >"charts/$scene.csv"
    rm -rf "charts/$scene"
  done
}

answers_of() {  # SIDE PROGRAM
  rm -rf "${out:?}/$1" && mkdir -p "$out/$1/runs"
  program=$2
  echo "answers of $program" >&2
  (cd "$out/$1" && all_answers)
}
answers_of old "$old"
answers_of new "$new"
find "$out/old" "$out/new" -type f | sed "s#^$out/[a-z]*/##" | sort -u >"$out/names"
differing=0
while read -r name; do
  cmp -s "$out/old/$name" "$out/new/$name" || { echo "differs: $name"; differing=$((differing + 1)); }
done <"$out/names"
echo "$(wc -l <"$out/names") answers compared, $differing differ"
[ "$differing" -eq 0 ]
