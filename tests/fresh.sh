#!/usr/bin/env bash
# Proves the README's two commands on a bare Debian 12: debootstrap into a folder, a clean clone of HEAD, chroot.
# Needs root. The mirror is that of this machine's own apt sources. Not part of CI (it takes about an hour on 2 cores).
#   tests/fresh.sh [FOLDER]     FOLDER: where to put the root (default: a new temporary one, removed in the end)
set -euo pipefail
[ "$(id -u)" -eq 0 ] || { echo "tests/fresh.sh: needs root (debootstrap and chroot)" >&2; exit 2; }
cd "$(dirname "$0")/.."
command -v debootstrap >/dev/null || { apt-get update -qq; apt-get install -y -qq debootstrap >/dev/null; }

mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE)' 2>/dev/null | awk '$2 ~ /^bookworm/ && !/security/ {print $1; exit}')
[ -n "$mirror" ] || { echo "tests/fresh.sh: this machine's apt sources name no Debian 12 (bookworm) mirror" >&2; exit 1; }

root=${1:-}
made=
if [ -z "$root" ]; then root=$(mktemp -d); made=1; fi
finish() {
  umount -q "$root/proc" "$root/dev/shm" "$root/dev" 2>/dev/null || true
  if [ -n "$made" ] && ! mountpoint -q "$root/proc" && ! mountpoint -q "$root/dev"; then rm -rf "$root"; fi
}
trap finish EXIT

echo "== a bare Debian 12 in $root"
[ -x "$root/bin/bash" ] || debootstrap --variant=minbase --include=git,ca-certificates bookworm "$root" "$mirror" >"$root.log" 2>&1 ||
  { tail "$root.log"; exit 1; }
# the machine's own way to its packages: sources, client settings, name look-up
rm -rf "$root/etc/apt/sources.list.d" "$root/etc/apt/sources.list"
cp -a /etc/apt/sources.list.d "$root/etc/apt/"
[ ! -e /etc/apt/sources.list ] || cp -a /etc/apt/sources.list "$root/etc/apt/"
cp -a /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/"
cp -aL /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir -p "$root/proc" "$root/dev"
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"

rm -rf "$root/home/borelli"
git clone -q "file://$PWD" "$root/home/borelli"
enter() { chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 bash -c "cd /home/borelli && $1"; }

for command in samples/run.sh tests/run.sh; do
  echo "== $command"
  began=$SECONDS
  enter "$command"
  echo "== $command passed in $((SECONDS - began)) s; once more"
  began=$SECONDS
  enter "$command" >/dev/null
  echo "== $command again: $((SECONDS - began)) s"
done

echo "== the Python module, by pip and away from its sources"
enter "BORELLI_BUILD=build/release pip install --quiet --no-index --no-build-isolation --break-system-packages . &&
  cd / && python3 /home/borelli/samples/python/scene_by_hand.py"
