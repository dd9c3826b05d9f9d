#!/usr/bin/env bash
# Installs and builds what is missing and runs the tests, except those of tests/long_tests.txt. Safe to repeat.
#   tests/run.sh [--long] [ARGUMENTS...]   --long: those too; ARGUMENTS go to ctest, e.g. -R dynamics
# Output of failed tests is printed in full and kept in build/release/Testing.
set -euo pipefail
cd "$(dirname "$0")/.."
./build.sh test
short=(-LE '^long$')
if [ "${1:-}" = --long ]; then short=(); shift; fi
ctest --preset release "${short[@]}" "$@"
