#!/usr/bin/env bash
# Makes the Debian packages of BUILD, unpacks them together and uses their contents.
#   tests/packages.sh BUILD [FOLDER]     FOLDER: where to leave the packages (default: nowhere)
set -euo pipefail
build=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
out=${2:-$work/packages}
cpack --config "$build/CPackConfig.cmake" -B "$out" >"$work/log" 2>&1 || { tail -n 30 "$work/log"; exit 1; }
rm -rf "$out/_CPack_Packages"
for package in "$out"/*.deb; do
  dpkg-deb --info "$package" | grep -E '^ (Package|Version|Depends|Installed-Size):'
  dpkg-deb -x "$package" "$work/root"
done
root=$work/root/usr
"$root/bin/borelli" --version
[ "$("$root/bin/borelli" --manual | cksum)" = "$(cksum <"$root/share/man/man1/borelli.1")" ]
grep -q _borelli "$root/share/bash-completion/completions/borelli"
# a scene of the package, and what is loaded at its first use (HDF5)
"$root/bin/borelli" simulate "$root/share/borelli/samples/double_pendulum.toml" -o "$work/motion.h5" >/dev/null
"$root/bin/borelli" info "$work/motion.h5" >/dev/null
[ -s "$root/include/borelli/dynamics/scene/scene.hpp" ]
[ -s "$root/lib/libborelli_dynamics.a" ]
if [ -d "$root/lib/python3" ]; then  # from the packages alone, with what is loaded at its first use
  (cd "$work" && PYTHONPATH="$root/lib/python3/dist-packages" /usr/bin/python3 -c "
import borelli
motion = borelli.read_trajectory('motion.h5')
assert borelli.__file__.startswith('$root') and motion.trusted and len(motion.times) > 10")
fi
