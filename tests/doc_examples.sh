#!/usr/bin/env bash
# doc_examples.sh DOCUMENT FOLDER: writes each fenced C++ block of the document whose first line is "// <path>" to
# FOLDER/<path>.
set -euo pipefail
grep -oE '^// [a-z_/]+\.hpp$' "$1" | while read -r _ file; do mkdir -p "$2/$(dirname "$file")"; done
awk -v folder="$2" '
  /^```cpp$/ { fenced = 1; file = ""; next }
  /^```$/ { fenced = 0; next }
  fenced && /^\/\/ [a-z_\/]+\.hpp$/ && !file { file = folder "/" $2; printf "" > file }
  fenced && file { print >> file }
' "$1"
