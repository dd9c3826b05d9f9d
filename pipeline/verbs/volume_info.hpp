// What a volume file or a DICOM folder holds, for `borelli info`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/verbs/verb.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {

/// Whether a path looks like a volume: a folder, or an ending of a volume's file.
bool may_be_volume(const std::string& path);

/// Format, grid (voxels, spacing in mm, directions, origin in mm, LPS), what the values are, their range,
/// labels with their volumes in ml. Nothing that names the patient. Where only the quantity is unclear,
/// "holds" is null and a warning gives the reason. Errors: as read_volume.
Result<nlohmann::json> volume_info(const Command& command, const std::string& path,
                                   const std::string& quantity, const Progress& progress);

/// The same for people.
std::string volume_info_text(const nlohmann::json& info);

}  // namespace borelli
