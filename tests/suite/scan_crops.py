#!/usr/bin/env python3
"""Prints how well pieces of a scan are segmented: scan_crops.py PROGRAM SCAN.nii.gz [SCAN.nii.gz ...]

Each scan is segmented whole, then in pieces that show neither both hips nor both shoulders. A figure is the share of
the piece's labelled voxels that get the same part as in the whole scan; a dash: the scan does not show the piece.
The scans' slices must go upwards.
"""
import gzip
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

# name: lower and upper bound as (landmark, mm above it), and the side that is kept
PIECES = {
    "abdomen, omphalion to xiphion": (("omphalion", -20), ("xiphion", 20), None),
    "pelvis above the femoral heads, and abdomen": (("hip_left", 40), ("xiphion", 40), None),
    "pelvis and abdomen, without shoulders": (("hip_left", -80), ("xiphion", 30), None),
    "trunk from the iliac spines to the armpits": (("hip_left", 60), ("shoulder_left", -60), None),
    "left leg below the hip": (("toe_tip_left", -1e4), ("hip_left", -150), "left"),
    "right leg below the hip": (("toe_tip_right", -1e4), ("hip_left", -150), "right"),
    "both knees, 240 mm": (("knee_left", -120), ("knee_left", 120), None),
    "left knee, 300 mm": (("knee_left", -150), ("knee_left", 150), "left"),
    "right knee, 300 mm": (("knee_left", -150), ("knee_left", 150), "right"),
}
TYPES = {2: np.uint8, 4: np.int16, 8: np.int32, 16: np.float32, 512: np.uint16}


def read_nifti(path):
    """Header bytes, the 3 x 4 affine (RAS, mm) and voxels (slice, row, column) of a NIfTI-1 file."""
    data = gzip.open(path).read()
    size = struct.unpack("<8h", data[40:56])[1:4]
    start = int(struct.unpack("<f", data[108:112])[0])
    voxels = np.frombuffer(data[start:], TYPES[struct.unpack("<h", data[70:72])[0]])
    affine = np.array(struct.unpack("<12f", data[280:328])).reshape(3, 4)
    return bytearray(data[:start]), affine, voxels[: np.prod(size)].reshape(size[::-1])


def write_piece(path, header, affine, voxels, low, high):
    piece, moved = voxels[low[2]:high[2], :, low[0]:high[0]], affine.copy()
    moved[:, 3] += affine[:, :3] @ [low[0], 0, low[2]]
    header = bytearray(header)
    header[280:328] = struct.pack("<12f", *moved.ravel())
    header[268:280] = struct.pack("<3f", *moved[:, 3])
    header[42:48] = struct.pack("<3h", *piece.shape[::-1])
    with gzip.open(path, "wb", 1) as file:
        file.write(bytes(header) + np.ascontiguousarray(piece).tobytes())
    return piece.shape


def segmented(program, scan, folder):
    subprocess.run([program, "segment", scan, "--quantity", "hu", "-o", folder], check=True, capture_output=True)
    points = json.loads((folder / "landmarks.json").read_text())["landmarks"]
    return read_nifti(folder / "labels.nii.gz")[2], {name: mark["point"] for name, mark in points.items()}


def share_right(program, scan, labels, marks, piece, folder):
    (low_mark, below), (high_mark, above), side = piece
    if not {low_mark, high_mark} & marks.keys() or (side and "mid_hip" not in marks):
        return None
    header, affine, voxels = scan
    index = lambda axis, value: (value - affine[axis, 3]) / affine[axis, axis]
    low, high = [0, 0, 0], list(voxels.shape[::-1])
    if low_mark in marks:  # else from the scan's own end
        low[2] = max(0, round(index(2, marks[low_mark][2] + below)))
    if high_mark in marks:
        high[2] = min(high[2], round(index(2, marks[high_mark][2] + above)))
    if side:  # landmarks are LPS, the affine RAS
        middle = round(index(0, -marks["mid_hip"][0]))
        (low if (affine[0, 0] < 0) == (side == "left") else high)[0] = middle
    if high[2] - low[2] < 8:
        return None
    write_piece(folder / "piece.nii.gz", header, affine, voxels, low, high)
    found, _ = segmented(program, folder / "piece.nii.gz", folder)
    exact = labels[low[2]:high[2], :, low[0]:high[0]]
    return np.count_nonzero((found == exact) & (exact > 0)) / np.count_nonzero(exact)


def main(program, *scans):
    rows = {name: [] for name in PIECES}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for path in scans:
            labels, marks = segmented(program, path, folder)
            scan = read_nifti(path)
            for name, piece in PIECES.items():
                share = share_right(program, scan, labels, marks, piece, folder)
                rows[name].append("-" if share is None else f"{share:.2f}")
    print("| piece |", " | ".join(Path(path).name.split(".")[0] for path in scans), "|")
    print("| --- |", " | ".join("---" for _ in scans), "|")
    for name, shares in rows.items():
        print(f"| {name} |", " | ".join(shares), "|")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
