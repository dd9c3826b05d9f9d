#!/usr/bin/env bash
# From the sample volume to a moving body: installs and builds what is missing, makes the phantom at 3 mm, runs the
# whole way on it. Safe to repeat; a run that was stopped goes on where it was.
set -euo pipefail
cd "$(dirname "$0")/.."
./build.sh run

out=${1:-out}
borelli=build/release/borelli
[ -n "${DISPLAY:-}" ] || borelli="xvfb-run -a $borelli"
mkdir -p "$out"
[ -s "$out/phantom.nii.gz" ] || $borelli phantom --spacing 3 --noise 20 -o "$out/phantom.nii.gz"
$borelli run "$out/phantom.nii.gz" --sex male --pose standing -o "$out"

cat <<END

Done. Where to look:
  $out/phantom/report.html            the report, with the body moving (any browser)
  $out/phantom/body.png               a picture
  $out/phantom/inertia/table.csv      mass, gravity centre and inertia tensor of each part
  $out/phantom_table.csv              the phantom's exact values, to compare with
  $out/phantom/model/scene.toml       the scene, to read and change (borelli simulate)
  $out/phantom/motion/trajectory.h5   the motion
END
