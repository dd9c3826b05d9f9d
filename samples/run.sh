#!/usr/bin/env bash
# From the sample volume to a walking body: installs and builds what is missing, makes the phantom at 3 mm with a
# captured walk, and runs all stages on it. Safe to repeat; a stopped run continues where it was.
set -euo pipefail
cd "$(dirname "$0")/.."
./build.sh run

out=${1:-out}
borelli=build/release/borelli
mkdir -p "$out"
[ -s "$out/phantom.nii.gz" ] && [ -s "$out/walk.trc" ] ||
  $borelli phantom --spacing 3 --noise 20 -o "$out/phantom.nii.gz" --walk "$out/walk"
$borelli run "$out/phantom.nii.gz" --sex male --pose standing -o "$out" \
  --motion "$out/walk.trc" --forces "$out/walk_grf.mot" --cut-off 0 --skin  # the made-up markers have no noise to filter

cat <<END

Done. Where to look:
  $out/phantom/report.html            the report, with the body walking and its joint moments (any browser)
  $out/phantom/body.png               a picture
  $out/phantom/inertia/table.csv      mass, gravity centre and inertia tensor of each part
  $out/phantom_table.csv              the phantom's exact values, to compare with
  $out/phantom/model/scene.toml       the scene, to read and change (borelli simulate)
  $out/phantom/motion/moments.sto     joint moments with their deviations (the exact ones: $out/walk_moments.sto)
  $out/phantom/motion/trajectory.h5   the motion
  $out/phantom/skin.glb               one skin that walks, for Blender or any glTF viewer

Without --motion the body leaps: borelli run "$out/phantom.nii.gz" --pose standing --subject leap -o "$out"
END
