#!/usr/bin/env bash
# Installs and builds what is missing and passes the tests, but for those of tests/long_tests.txt. Safe to repeat.
#   tests/run.sh [--long] [WORDS...]   --long: those too; WORDS go to ctest, e.g. -R dynamics
# What failed is printed in full, and kept in build/release/Testing.
set -euo pipefail
cd "$(dirname "$0")/.."
./build.sh test
short=(-LE '^long$')
if [ "${1:-}" = --long ]; then short=(); shift; fi
ctest --preset release "${short[@]}" "$@"
