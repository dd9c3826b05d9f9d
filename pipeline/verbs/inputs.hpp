// What verbs read: each of these passes on all that the reader said (Command::warn), so that no verb can lose
// it. An empty path: nothing is given, and the answer is empty.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/model_file.hpp"
#include "inertia/table.hpp"
#include "pipeline/verbs/verb.hpp"
#include "segmentation/class_map.hpp"
#include "segmentation/given_landmarks.hpp"
#include "segmentation/read.hpp"

namespace borelli {

/// `quantity` as on the command line; empty: not said.
Result<ScannedVolume> read_volume(const Command& command, const std::string& path,
                                  const std::string& quantity = "", const Progress& progress = {});
/// `scan`: the grid that the labels are put on.
Result<LabelMap> read_labels(const Command& command, const std::string& path, const std::string& names = "",
                             const Grid* scan = nullptr);
Result<ClassMap> read_classes(const Command& command, const std::string& path, const std::string& names,
                              const std::string& mapping);
Result<GivenLandmarks> read_given_landmarks(const Command& command, const std::string& path);
Result<InertiaTable> read_table(const Command& command, const std::string& path);
Result<ModelFile> read_model(const Command& command, const std::string& path, const ModelOptions& options);

}  // namespace borelli
