#!/usr/bin/env bash
# readme_examples.sh README FOLDER: writes each fenced C++ block of the README whose first line is "// <path>" to
# FOLDER/<path>.
set -euo pipefail
mkdir -p "$2/dynamics"
awk -v folder="$2" '
  /^```cpp$/ { fenced = 1; file = ""; next }
  /^```$/ { fenced = 0; next }
  fenced && /^\/\/ [a-z_\/]+\.hpp$/ && !file { file = folder "/" $2; printf "" > file }
  fenced && file { print >> file }
' "$1"
