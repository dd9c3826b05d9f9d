#!/usr/bin/env bash
# The manual page and the completion hold what --help lists, verb by verb.
#   tests/manual.sh PROGRAM
set -euo pipefail
program=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$1" >&2; exit 1; }

"$program" --manual >"$work/borelli.1"
groff -man -ww -Tascii -P-cbou -rLL=200n "$work/borelli.1" >"$work/page" 2>"$work/complaints"
[ ! -s "$work/complaints" ] || fail "groff complains: $(head -n 3 "$work/complaints")"

mapfile -t verbs < <("$program" --help | awk '/^Subcommands:/ {inside = 1; next} inside && /^  [a-z]/ {print $1}')
[ "${#verbs[@]}" -gt 15 ] || fail "--help lists ${#verbs[@]} verbs"
for verb in "${verbs[@]}"; do
  awk -v verb="borelli $verb" 'index($0, "   " verb) == 1 && substr($0, length(verb) + 4) ~ /^( |$)/ {inside = 1; next}
                               /^   borelli |^[A-Z]/ {inside = 0} inside' "$work/page" >"$work/section"
  [ -s "$work/section" ] || fail "the manual page has no section of $verb"
  while read -r flag; do
    grep -q -- "$flag\b" "$work/section" || fail "the manual page does not name $flag of $verb"
  done < <("$program" "$verb" --help | grep -oE '^  (-[a-z],)?--[a-z0-9-]+' | grep -oE -- '--[a-z0-9-]+' | grep -v '^--help$')
done

"$program" --completion >"$work/completion"
source "$work/completion"
completed() {  # words of a command line, the last one to complete
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  _borelli
  echo "${COMPREPLY[*]}"
}
expect() { [ "$1" = "$2" ] || fail "completes to '$1' instead of '$2'"; }
expect "$(completed borelli sim)" simulate
expect "$(completed borelli phantom --sex f)" female
expect "$(completed borelli --thr)" --threads
expect "$(completed borelli segment scan.nii.gz --quan)" --quantity
expect "$(completed borelli segment sca)" ""  # a file
