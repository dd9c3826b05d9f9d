#!/usr/bin/env python3
"""Writes a label map in TotalSegmentator's form from the phantom's solids, for class_file_test.cpp.

write_classes.py FOLDER VERSION OUTPUT [--no-names] [--masks]
VERSION is 1, 2, or mr for the task total_mr. With --masks OUTPUT is a folder that gets a mask per class (its default output).
FOLDER holds solids.raw (int32, the number of the solid at each voxel or -1, first axis fastest), solids.txt (a solid's
name a line) and grid.txt (the size, then the affine's rows in LPS, mm). Shares no code with the program: the format is
that of NIfTI-1 with the extension that TotalSegmentator's nifti_ext_header.py adds, the numbers those of class_labels
"total" (version 2), "total_v1" (1) or "total_mr" (mr) in its map_to_binary.py.
"""
import gzip
import os
import re
import struct
import sys

import numpy as np

column = [f"vertebrae_{v}" for v in
          ["L5", "L4", "L3", "L2", "L1"] + [f"T{n}" for n in range(12, 0, -1)] + [f"C{n}" for n in range(7, 0, -1)]]
ribs = [f"rib_{side}_{n}" for side in ("left", "right") for n in range(1, 13)]


def sides(*stems, order=("left", "right")):
    return [f"{stem}_{side}" for stem in stems for side in order]


total = ("spleen kidney_right kidney_left gallbladder liver stomach pancreas adrenal_gland_right adrenal_gland_left "
         "lung_upper_lobe_left lung_lower_lobe_left lung_upper_lobe_right lung_middle_lobe_right lung_lower_lobe_right "
         "esophagus trachea thyroid_gland small_bowel duodenum colon urinary_bladder prostate kidney_cyst_left "
         "kidney_cyst_right sacrum vertebrae_S1").split() + column + (
    "heart aorta pulmonary_vein brachiocephalic_trunk subclavian_artery_right subclavian_artery_left "
    "common_carotid_artery_right common_carotid_artery_left brachiocephalic_vein_left brachiocephalic_vein_right "
    "atrial_appendage_left superior_vena_cava inferior_vena_cava portal_vein_and_splenic_vein").split() + sides(
    "iliac_artery", "iliac_vena", "humerus", "scapula", "clavicula", "femur", "hip") + ["spinal_cord"] + sides(
    "gluteus_maximus", "gluteus_medius", "gluteus_minimus", "autochthon", "iliopsoas") + ["brain", "skull"] + ribs + [
    "sternum", "costal_cartilages"]

total_v1 = ("spleen kidney_right kidney_left gallbladder liver stomach aorta inferior_vena_cava "
            "portal_vein_and_splenic_vein pancreas adrenal_gland_right adrenal_gland_left lung_upper_lobe_left "
            "lung_lower_lobe_left lung_upper_lobe_right lung_middle_lobe_right lung_lower_lobe_right").split() + column + (
    "esophagus trachea heart_myocardium heart_atrium_left heart_ventricle_left heart_atrium_right "
    "heart_ventricle_right pulmonary_artery brain").split() + sides("iliac_artery", "iliac_vena") + [
    "small_bowel", "duodenum", "colon"] + ribs + sides("humerus", "scapula", "clavicula", "femur", "hip") + [
    "sacrum", "face"] + sides("gluteus_maximus", "gluteus_medius", "gluteus_minimus", "autochthon", "iliopsoas") + [
    "urinary_bladder"]

total_mr = ("spleen kidney_right kidney_left gallbladder liver stomach pancreas adrenal_gland_right adrenal_gland_left lung_left "
            "lung_right esophagus small_bowel duodenum colon urinary_bladder prostate sacrum vertebrae intervertebral_discs "
            "spinal_cord heart aorta inferior_vena_cava portal_vein_and_splenic_vein").split() + sides(
    "iliac_artery", "iliac_vena", "humerus", "scapula", "clavicula", "femur", "hip", "gluteus_maximus", "gluteus_medius",
    "gluteus_minimus", "autochthon", "iliopsoas") + ["brain"]

# TotalSegmentator's class of a solid of the phantom; the first matching pattern counts
rules = [(r"rib \d+ \w+ cartilage", "costal_cartilages"), (r"rib (\d+) (left|right)", r"rib_\2_\1"),
         (r"([CTL]\d+)(?! disc)", r"vertebrae_\1"), (r"(?:humer\w*(?: \w+)?) (left|right)", r"humerus_\1"),
         (r"(?:femoral head|femoral neck|femur|medial condyle|lateral condyle) (left|right)", r"femur_\1"),
         (r"(?:ilium|asis|acetabulum|ischium|pubis|ramus) (left|right)", r"hip_\1"),
         (r"(?:scapula|acromion|glenoid) (left|right)", r"scapula_\1"), (r"clavicle (left|right)", r"clavicula_\1"),
         (r"lung (left|right)", r"lung_upper_lobe_\1"), (r"(sacrum|sternum|brain|heart|liver|trachea)", r"\1"),
         (r"(?:skull|maxilla|mandible)", "skull")]


def class_of(solid):
    for pattern, name in rules:
        match = re.match(pattern, solid)
        if match:
            return of_mr(match.expand(name)) if version == "mr" else match.expand(name)
    return None


def of_mr(name):  # total_mr has whole lungs and one class of vertebrae
    return re.sub(r"vertebrae_\w+", "vertebrae", name.replace("lung_upper_lobe", "lung"))


def extension(names):
    labels = "".join(f'<Label Key="{n}" Red="1.0" Green="0.0" Blue="0.0" Alpha="1"><![CDATA[{name}]]></Label>\n'
                     for n, name in names.items())
    xml = ('<?xml version="1.0" encoding="UTF-8"?> <CaretExtension>  <Date><![CDATA[2013-07-14T05:45:09]]></Date>   '
           '<VolumeInformation Index="0">   <LabelTable>\n' + labels + "\n  </LabelTable>  <StudyMetaDataLinkSet>  "
           "</StudyMetaDataLinkSet>  <VolumeType><![CDATA[Label]]></VolumeType>   </VolumeInformation></CaretExtension>"
           "\n              ").encode()
    size = -(-(len(xml) + 8) // 16) * 16
    return struct.pack("<4B2i", 1, 0, 0, 0, size, 0) + xml.ljust(size - 8, b"\0")


def nifti(path, voxels, affine_lps, tail):
    """voxels: (x, y, z) uint8; affine_lps: 3 x 4."""
    affine = np.diag([-1.0, -1.0, 1.0]) @ affine_lps
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *voxels.shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)  # uint8, 8 bits
    struct.pack_into("<8f", header, 76, 1, *np.linalg.norm(affine[:, :3], axis=0), 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 348 + len(tail), 1, 0)
    header[123] = 2  # mm
    struct.pack_into("<2h", header, 252, 0, 1)  # sform: scanner
    struct.pack_into("<12f", header, 280, *affine.ravel())
    header[344:348] = b"n+1\0"
    with gzip.open(path, "wb") as file:
        file.write(bytes(header) + tail + voxels.tobytes(order="F"))


folder, version, output = sys.argv[1:4]
names = {n: name for n, name in enumerate({"2": total, "1": total_v1, "mr": total_mr}[version], 1)}
number = {name: n for n, name in names.items()}
lines = open(f"{folder}/grid.txt").read().split()
size = [int(n) for n in lines[:3]]
solids = np.fromfile(f"{folder}/solids.raw", np.int32).reshape(size, order="F")
of_solid = [number.get(class_of(line.rstrip("\n")), 0) for line in open(f"{folder}/solids.txt")]
classes = np.array(of_solid + [0], np.uint8)[solids]  # -1: the last
affine = np.array(lines[3:], float).reshape(3, 4)
if "--masks" in sys.argv:
    os.makedirs(output, exist_ok=True)
    for n, name in names.items():
        nifti(f"{output}/{name}.nii.gz", (classes == n).astype(np.uint8), affine, bytes(4))
    open(f"{output}/statistics.json", "w").write("{}")
else:
    nifti(output, classes, affine, bytes(4) if "--no-names" in sys.argv else extension(names))
for n, name in names.items():
    print(n, name, int((classes == n).sum()))
