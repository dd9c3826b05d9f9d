"""The inertia table of a CT: inertia_from_ct.py [SCAN.nii.gz]. Without a scan: of the sample body."""
import sys

import borelli

volume = borelli.read_volume(sys.argv[1]) if len(sys.argv) > 1 else borelli.phantom(spacing=6).volume
found = borelli.segment(volume, callback=lambda share, step: print(f"{share:4.0%} {step}", file=sys.stderr))
print(f"segmentation: {found.verdict}")

hip = found.landmarks["hip_left"]
print(f"left hip at {hip.point.round(1)} mm, standard deviation {hip.deviation:.1f} mm\n")

table = borelli.inertia(volume, found, sex="male")
frame = table.to_pandas()
print(frame[["mass_kg", "mass_kg_sd", "mass_pct", "length_m", "centre_pct"]].round(3))
