#!/usr/bin/env python3
"""Makes matching and wrong pairs of a CT and TotalSegmentator's labels from the ICRP 110 bodies, for class_fit_test.cpp.

write_pairs.py VOLUMES SEED FOLDER
VOLUMES holds icrp_am and icrp_af. Writes FOLDER/ct.nii and FOLDER/labels.nii (numbers of task "total", version 2) and prints what the
pair is: "genuine", "flip", "shift" or "foreign", and what was done to it. Shares no code with the program.
Genuine pairs differ as real ones do: labels from a grid of 1.5 or 3 mm, bones a voxel fatter or thinner, some classes only, a piece
of the scan, noise, contrast medium in vessels and organs, an origin rounded, the head turned by less than half a degree.
"""
import gzip
import random
import struct
import sys

import numpy as np
from scipy import ndimage

volumes, seed, folder = sys.argv[1], int(sys.argv[2]), sys.argv[3]
bones = {"humerus": range(13, 19), "femur": range(28, 34), "hip": (41, 42), "scapula": (45, 46), "clavicula": (24, 25)}
number = {"spleen": 1, "kidney_right": 2, "kidney_left": 3, "liver": 5, "stomach": 6, "pancreas": 7, "lung_upper_lobe_left": 10,
          "lung_lower_lobe_left": 11, "lung_upper_lobe_right": 12, "lung_lower_lobe_right": 14, "small_bowel": 18, "colon": 20,
          "urinary_bladder": 21, "sacrum": 25, "vertebrae_L3": 29, "vertebrae_T6": 38, "vertebrae_C4": 47, "heart": 51, "humerus_left": 69,
          "humerus_right": 70, "scapula_left": 71, "scapula_right": 72, "clavicula_left": 73, "clavicula_right": 74, "femur_left": 75,
          "femur_right": 76, "hip_left": 77, "hip_right": 78, "spinal_cord": 79, "brain": 90, "skull": 91, "rib_left_6": 97,
          "rib_right_6": 109, "sternum": 116}
contrast = [number[n] for n in ("spleen", "kidney_left", "kidney_right", "liver", "heart")]
bone_numbers = [25, 29, 38, 47, *range(69, 79), 91, 97, 109, 116]


def read(path):
    data = gzip.open(path).read()
    shape = struct.unpack_from("<3h", data, 42)
    kind = {2: "u1", 4: "<i2", 8: "<i4", 16: "<f4", 512: "<u2"}[struct.unpack_from("<h", data, 70)[0]]
    start = int(struct.unpack_from("<f", data, 108)[0])
    affine = np.array(struct.unpack_from("<12f", data, 280)).reshape(3, 4)
    return np.frombuffer(data, kind, int(np.prod(shape)), start).reshape(shape, order="F"), affine  # RAS


def write(path, voxels, affine):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *voxels.shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, *((2, 8) if voxels.dtype == np.uint8 else (4, 16)))
    struct.pack_into("<8f", header, 76, 1, *np.linalg.norm(affine[:, :3], axis=0), 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, *affine.ravel())
    header[344:348] = b"n+1\0"
    open(path, "wb").write(bytes(header) + voxels.tobytes(order="F"))


def body(name):
    short = name[-2:].upper()
    organs, affine = read(f"{volumes}/{name}/{short}_labels.nii.gz")
    ct, _ = read(f"{volumes}/{name}/{short}_hu.nii.gz")
    classes = np.zeros(organs.shape, np.uint8)
    x = (np.arange(organs.shape[0]) * affine[0, 0] + affine[0, 3])[:, None, None]
    spine = np.isin(organs, range(49, 55))
    middle = (x * spine).sum() / spine.sum()
    left = np.broadcast_to(x < middle, organs.shape)  # x runs to the right
    high = np.arange(organs.shape[2])[None, None, :]

    def put(mask, stem):
        if stem in number:
            classes[mask] = number[stem]
        else:
            side_at = stem.find("*")
            classes[mask & left] = number[stem[:side_at] + "left" + stem[side_at + 1:]]
            classes[mask & ~left] = number[stem[:side_at] + "right" + stem[side_at + 1:]]

    for stem, ids in bones.items():
        put(np.isin(organs, ids), stem + "_*")
    put(np.isin(organs, (26, 27, 39, 40, 128)), "skull"), put(organs == 61, "brain"), put(np.isin(organs, (53, 54)), "sacrum")
    put(np.isin(organs, (55, 56)), "sternum"), put(organs == 126, "spinal_cord"), put(np.isin(organs, (43, 44)), "rib_*_6")
    put(np.isin(organs, (47, 48)), "vertebrae_C4"), put(np.isin(organs, (49, 50)), "vertebrae_T6")
    put(np.isin(organs, (51, 52)), "vertebrae_L3"), put(organs == 127, "spleen"), put(organs == 95, "liver"), put(organs == 113, "pancreas")
    put(np.isin(organs, (89, 90, 91)), "kidney_left"), put(np.isin(organs, (92, 93, 94)), "kidney_right")
    put(np.isin(organs, (72, 73)), "stomach"), put(np.isin(organs, (74, 75)), "small_bowel"), put(np.isin(organs, range(76, 87)), "colon")
    put(np.isin(organs, (137, 138)), "urinary_bladder"), put(np.isin(organs, (87, 88)), "heart")
    lungs = np.isin(organs, range(96, 100))
    slices = np.flatnonzero(lungs.any((0, 1)))
    put(lungs & (high > slices.mean()), "lung_upper_lobe_*"), put(lungs & (high <= slices.mean()), "lung_lower_lobe_*")
    return ct.astype(np.int16), classes, affine


draw, noise = random.Random(seed), np.random.default_rng(seed)
names = ["icrp_am", "icrp_af"]
draw.shuffle(names)
ct, labels, affine = body(names[0])
place, done = affine.copy(), [names[0]]
ct = ct + noise.normal(0, draw.choice([1, 10, 25]), ct.shape).astype(np.int16)
if draw.random() < 0.4:
    grid = draw.choice([1.5, 3.0])
    spacing = np.linalg.norm(affine[:, :3], axis=0)
    small = ndimage.zoom(labels, np.minimum(1, spacing / grid), order=0)
    back = [np.clip(np.rint((np.arange(n) + 0.5) * m / n - 0.5).astype(int), 0, m - 1) for n, m in zip(labels.shape, small.shape)]
    labels = small[np.ix_(*back)]
    done.append(f"from {grid} mm")
shape = draw.random()
is_bone = np.isin(labels, bone_numbers)
if shape < 0.2:
    grown = ndimage.grey_dilation(np.where(is_bone, labels, 0), size=(3, 3, 1))
    labels = np.where((labels == 0) & (grown > 0), grown, labels).astype(np.uint8)
    done.append("fat bones")
elif shape < 0.4:
    cross = np.zeros((3, 3, 3), bool)
    cross[:, 1, 1] = cross[1, :, 1] = True
    labels = np.where(is_bone & ~ndimage.binary_erosion(is_bone, cross), 0, labels).astype(np.uint8)
    done.append("thin bones")
if draw.random() < 0.4:
    there = [n for n in np.unique(labels) if n]
    keep = draw.sample(there, min(len(there), draw.randint(4, 20)))
    labels = np.where(np.isin(labels, keep), labels, 0).astype(np.uint8)
    done.append(f"{len(keep)} classes")
if draw.random() < 0.4:
    ct[np.isin(labels, contrast)] += draw.choice([60, 150, 250])
    done.append("contrast")
if draw.random() < 0.4:
    place[:, 3] += noise.uniform(-0.6, 0.6, 3)
    done.append("origin rounded")
if draw.random() < 0.3:
    angle = np.deg2rad(draw.uniform(-0.4, 0.4))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    middle = place[:, :3] @ (np.array(labels.shape) / 2) + place[:, 3]
    place = np.c_[turn @ place[:, :3], turn @ (place[:, 3] - middle) + middle]
    done.append("turned")
if draw.random() < 0.3:
    first = draw.randrange(labels.shape[2] - 60)
    last = first + draw.randint(50, labels.shape[2] - first)
    ct, labels = ct[:, :, first:last], labels[:, :, first:last]
    affine = np.c_[affine[:, :3], affine[:, 3] + first * affine[:, 2]]
    place = np.c_[place[:, :3], place[:, 3] + first * place[:, 2]]
    done.append("a piece")
what, chance = "genuine", draw.random()
if 0.5 < chance < 0.65:
    axis = draw.randrange(3)
    what, labels = "flip", np.flip(labels, axis)
    done.append("xyz"[axis])
elif 0.65 <= chance < 0.85:
    shift = noise.normal(size=3)
    shift *= draw.uniform(12, 40) / np.linalg.norm(shift)
    what = "shift"
    place[:, 3] += shift
    done.append("%.0f mm" % np.linalg.norm(shift))
elif chance >= 0.85:
    _, labels, place = body(names[1])
    what = "foreign"
    middle = [a[:, :3] @ (np.array(v.shape) / 2) + a[:, 3] for v, a in ((ct, affine), (labels, place))]
    place[:, 3] += middle[0] - middle[1]
write(f"{folder}/ct.nii", ct, affine)
write(f"{folder}/labels.nii", labels, place)
print(what, ", ".join(done))
