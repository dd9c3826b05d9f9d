#!/usr/bin/env bash
# Installs and builds what is missing and passes the tests. Safe to repeat. Further words go to ctest
# (e.g. tests/run.sh -R dynamics). What failed is printed in full, and kept in build/release/Testing.
set -euo pipefail
cd "$(dirname "$0")/.."
./build.sh test
display=()
[ -n "${DISPLAY:-}" ] || display=(xvfb-run -a)  # VTK draws only under one; without it the tests of pictures are skipped
"${display[@]}" ctest --preset release "$@"
