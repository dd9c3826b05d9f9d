// Describes a volume file or a DICOM folder for `borelli info`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/verbs/verb.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {

/// Whether a path looks like a volume: a folder, or a file with a volume's extension.
bool may_be_volume(const std::string& path);

/// Format, grid (voxels, spacing in mm, directions, origin in mm, LPS), quantity and range of the values,
/// labels with their volumes in ml. Never identifies the patient. If only the quantity is unclear, "holds" is
/// null and a warning gives the reason. Errors: as read_volume.
Result<nlohmann::json> volume_info(const Command& command, const std::string& path,
                                   const std::string& quantity, const Progress& progress);

/// The same as text.
std::string volume_info_text(const nlohmann::json& info);

}  // namespace borelli
