#!/usr/bin/env bash
# Installs BUILD below a temporary prefix, then builds and runs tests/consumer against this installation only.
#   tests/install.sh BUILD
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/prefix" >/dev/null
"$work/prefix/bin/borelli" --version
if grep -rlF "$(dirname "$here")" "$work/prefix" --include='*.hpp' --include='*.cmake'; then
  echo "installed files above name the source folder" >&2
  exit 1
fi
cmake -G Ninja -S "$here/consumer" -B "$work/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" \
  >"$work/log" 2>&1 || { tail -n 30 "$work/log"; exit 1; }
cmake --build "$work/build" >"$work/log" 2>&1 || { tail -n 30 "$work/log"; exit 1; }
for consumer in "$work"/build/consumer*; do  # one per instruction set; not every processor has AVX2
  case $consumer in
    *_mfma | *_mavx2 | *_v3) grep -q avx2 /proc/cpuinfo && grep -q fma /proc/cpuinfo || continue ;;
  esac
  "$consumer" || { echo "${consumer##*/} fails: $?" >&2; exit 1; }
done
