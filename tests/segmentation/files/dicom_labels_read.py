#!/usr/bin/env python3
"""Prints what pydicom reads in a DICOM segmentation: dicom_labels_read.py FILE

A line per set pixel: its segment's label, and its patient coordinates in mm (PS3.3, C.7.6.2.1.1). In order of frames.
"""
import sys

import numpy
import pydicom

data = pydicom.dcmread(sys.argv[1])
shared = data.SharedFunctionalGroupsSequence[0]
orientation = [float(x) for x in shared.PlaneOrientationSequence[0].ImageOrientationPatient]
row, column = numpy.array(orientation[:3]), numpy.array(orientation[3:])
between_rows, between_columns = (float(x) for x in shared.PixelMeasuresSequence[0].PixelSpacing)
names = {segment.SegmentNumber: segment.SegmentLabel for segment in data.SegmentSequence}
pixels = data.pixel_array.reshape(int(data.NumberOfFrames), data.Rows, data.Columns)
for frame, groups in zip(pixels, data.PerFrameFunctionalGroupsSequence):
    name = names[groups.SegmentIdentificationSequence[0].ReferencedSegmentNumber]
    start = numpy.array([float(x) for x in groups.PlanePositionSequence[0].ImagePositionPatient])
    for j, i in zip(*numpy.nonzero(frame)):
        x, y, z = start + i * between_columns * row + j * between_rows * column
        print(name, repr(float(x)), repr(float(y)), repr(float(z)), sep="\t")
