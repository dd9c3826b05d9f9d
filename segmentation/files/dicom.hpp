// Reads a folder of DICOM slices as one volume.
#pragma once

#include <string>

#include "segmentation/files/read.hpp"
#include "segmentation/files/slice_stack.hpp"

namespace borelli {

/// Finds the series in a folder and its subfolders. Takes the largest CT series, else the largest of another
/// modality, and says which. Errors: no DICOM images, several volumes in one series that cannot be told
/// apart, colours, multi-frame files without frame positions, and those of stack_slices and
/// read_dicom_pixels.
Result<ScannedVolume> read_dicom_folder(const std::string& folder, const ReadOptions& options);

/// The slices of the series that read_dicom_folder reads, and their grid, without pixels. The first notes say
/// why this series was chosen. Errors: those of read_dicom_folder about headers.
Result<SliceStack> find_dicom_stack(const std::string& folder, const Progress& progress = {});

}  // namespace borelli
