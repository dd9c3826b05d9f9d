#!/usr/bin/env bash
# Installs what the build needs and is missing (Debian packages), configures and builds.
#   build.sh run     the program                     (BORELLI_TESTS=OFF)
#   build.sh test    the program, tests, benchmarks
# Safe to repeat. The build lies in build/release; ccache is used, so that a repeat costs seconds.
set -euo pipefail
cd "$(dirname "$0")"

run_packages=(g++ cmake ninja-build ccache libeigen3-dev libgdcm-dev libvtk9-dev libhdf5-dev libcli11-dev
  libtomlplusplus-dev nlohmann-json3-dev libfmt-dev libexpected-dev libtinygltf-dev libssl-dev zlib1g-dev libbz2-dev libisal-dev libexpat1-dev
  libqhull-dev libfcl-dev libsundials-dev libegl-dev libegl-mesa0 libgl1-mesa-dri libglew-dev
  libinsighttoolkit5-dev libfftw3-dev librsvg2-dev ffmpeg)
test_packages=(libgtest-dev libbenchmark-dev libmujoco-dev libsimbody-dev libtinyxml2-dev dcmtk dicom3tools python3-pydicom groff-base dpkg-dev file
  python3 python3-numpy python3-h5py python3-dev pybind11-dev python3-pandas mypy
  python3-pip python3-setuptools python3-wheel chromium)

packages=("${run_packages[@]}")
tests=OFF targets=(--target program)
case "${1:-}" in
  run) ;;
  test) packages+=("${test_packages[@]}") tests=ON targets=() ;;
  *) echo "usage: build.sh run|test" >&2; exit 2 ;;
esac

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  echo "Installing: ${missing[*]}"
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "build.sh: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    -o Dpkg::Use-Pty=0 "${missing[@]}" >/dev/null
fi

mkdir -p build
log=build/configure.log
cmake --preset release -DBORELLI_TESTS=$tests >"$log" 2>&1 || { tail -n 40 "$log"; exit 1; }
cmake --build --preset release "${targets[@]}"
