#!/usr/bin/env bash
# tidy.sh [BASE]: runs clang-tidy (.clang-tidy) on the sources that differ from commit BASE (default: HEAD~1).
set -euo pipefail
cd "$(dirname "$0")/.."
base=${1:-HEAD~1}
mapfile -t changed < <(git diff --name-only --diff-filter=d "$base" -- 'error/*.cpp' 'process/*.cpp' 'threads/*.cpp' \
  'segmentation/*.cpp' 'inertia/*.cpp' 'dynamics/*.cpp' 'samples/*.cpp' 'pipeline/*.cpp')
[ ${#changed[@]} -gt 0 ] || { echo "no source differs from $base"; exit 0; }
# (a unity build knows no single files)
cmake --preset release -B build/tidy -DCMAKE_UNITY_BUILD=OFF -DBORELLI_TESTS=OFF >/dev/null
printf '%s\n' "${changed[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy -p build/tidy --quiet
