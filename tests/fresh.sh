#!/usr/bin/env bash
# Proves the README's two commands on a bare Debian 12: debootstrap into a folder, a clean clone of HEAD, chroot. Then makes
# the packages there, installs them on a second bare Debian 12 and runs a scan.
# Needs root. The mirror is that of this machine's own apt sources. Not part of CI (it takes about an hour on 2 cores).
#   tests/fresh.sh [FOLDER]              FOLDER: where to put the roots (default: a new temporary one, removed in the end)
#   tests/fresh.sh --packages PACKAGES   the second part alone, with the .deb files of this folder
set -euo pipefail
[ "$(id -u)" -eq 0 ] || { echo "tests/fresh.sh: needs root (debootstrap and chroot)" >&2; exit 2; }
cd "$(dirname "$0")/.."
command -v debootstrap >/dev/null || { apt-get update -qq; apt-get install -y -qq debootstrap >/dev/null; }

mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE)' 2>/dev/null | awk '$2 ~ /^bookworm/ && !/security/ {print $1; exit}')
[ -n "$mirror" ] || { echo "tests/fresh.sh: this machine's apt sources name no Debian 12 (bookworm) mirror" >&2; exit 1; }

packages=
if [ "${1:-}" = --packages ]; then packages=$(cd "$2" && pwd); shift 2; fi
folder=${1:-}
made=
if [ -z "$folder" ]; then folder=$(mktemp -d); made=1; fi
roots=("$folder/build" "$folder/use")
finish() {
  for root in "${roots[@]}"; do umount -q "$root/proc" "$root/dev/shm" "$root/dev" 2>/dev/null || true; done
  if [ -n "$made" ] && ! mount | grep -q "on $folder/"; then rm -rf "$folder"; fi
}
trap finish EXIT

bare() {  # root, packages of a minimal system
  echo "== a bare Debian 12 in $1"
  mkdir -p "$1"
  [ -x "$1/bin/bash" ] || debootstrap --variant=minbase --include="$2" bookworm "$1" "$mirror" >"$1.log" 2>&1 ||
    { tail "$1.log"; exit 1; }
  # the machine's access to packages: sources, client settings, name look-up
  rm -rf "$1/etc/apt/sources.list.d" "$1/etc/apt/sources.list"
  cp -a /etc/apt/sources.list.d "$1/etc/apt/"
  [ ! -e /etc/apt/sources.list ] || cp -a /etc/apt/sources.list "$1/etc/apt/"
  cp -a /etc/apt/apt.conf.d/. "$1/etc/apt/apt.conf.d/"
  cp -aL /etc/resolv.conf /etc/hosts "$1/etc/"
  mkdir -p "$1/proc" "$1/dev"
  mount -t proc proc "$1/proc"
  mount --bind /dev "$1/dev"
}
enter() { chroot "$1" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 bash -c "$2"; }

use_packages() {  # folder of packages
  local root=${roots[1]}
  bare "$root" ca-certificates
  mkdir -p "$root/packages" && cp "$1"/*.deb "$root/packages/"
  echo "== the packages, installed and used"
  enter "$root" "apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    /packages/borelli_*.deb \$(ls /packages/python3-borelli_*.deb 2>/dev/null) ffmpeg >/dev/null && borelli --version"
  began=$SECONDS
  enter "$root" "cd /root && borelli phantom -o phantom.nii.gz --spacing 4 && borelli run phantom.nii.gz -o out \
    && ls -l out/phantom/report.html out/phantom/body.png && borelli simulate /usr/share/borelli/samples/pendulum.toml -o p.h5"
  [ ! -d "$root/usr/lib/python3/dist-packages/borelli" ] ||
    enter "$root" "cd /root && python3 -c 'import borelli; print(borelli.read_trajectory(\"p.h5\").trusted)'"
  echo "== a scan from volume to report took $((SECONDS - began)) s"
}

if [ -n "$packages" ]; then use_packages "$packages"; exit; fi

root=${roots[0]}
bare "$root" git,ca-certificates
rm -rf "$root/home/borelli"
git clone -q "file://$PWD" "$root/home/borelli"

for command in samples/run.sh tests/run.sh; do
  echo "== $command"
  began=$SECONDS
  enter "$root" "cd /home/borelli && $command"
  echo "== $command passed in $((SECONDS - began)) s; once more"
  began=$SECONDS
  enter "$root" "cd /home/borelli && $command" >/dev/null
  echo "== $command again: $((SECONDS - began)) s"
done

echo "== the Python module, by pip and away from its sources"
enter "$root" "cd /home/borelli && BORELLI_BUILD=build/release pip install --quiet --no-index --no-build-isolation --break-system-packages . &&
  cd / && python3 /home/borelli/samples/python/scene_by_hand.py"

echo "== the packages"
enter "$root" "cd /home/borelli && tests/packages.sh build/release /packages"
use_packages "$root/packages"
