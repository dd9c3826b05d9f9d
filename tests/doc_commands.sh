#!/usr/bin/env bash
# doc_commands.sh DOCUMENT PROGRAM: runs the fenced `sh` blocks of the document in an empty folder, one after the other, with
# PROGRAM as `borelli`. A command that fails ends it.
set -euo pipefail
document=$(realpath "$1")
program=$(realpath "$2")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/bin" "$folder/work"
ln -s "$program" "$folder/bin/borelli"
awk '/^```sh$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$document" >"$folder/commands"
[ -s "$folder/commands" ] || { echo "$1 has no sh block" >&2; exit 1; }
cd "$folder/work"
PATH=$folder/bin:$PATH bash -euo pipefail "$folder/commands"
