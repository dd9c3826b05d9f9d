// Readers for verbs: each passes the file reader's warnings on to the Command, so that no verb loses them.
#pragma once

#include <string>

#include "dynamics/formats/model_file.hpp"
#include "inertia/table.hpp"
#include "pipeline/verbs/verb.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {

/// `quantity`: the value of --quantity; empty: not given.
Result<ScannedVolume> read_volume(const Command& command, const std::string& path,
                                  const std::string& quantity = "", const Progress& progress = {});
/// `scan`: the grid to put the labels on. Warnings name `path`, since a verb also reads a volume.
Result<LabelMap> read_labels(const Command& command, const std::string& path, const std::string& names = "",
                             const Grid* scan = nullptr);
Result<ClassLabels> read_classes(const Command& command, const std::string& path, const std::string& names,
                                 const std::string& mapping, const GreyVolume& scan);
/// No landmarks where `path` is empty.
Result<GivenLandmarks> read_given_landmarks(const Command& command, const std::string& path);
Result<InertiaTable> read_table(const Command& command, const std::string& path);
/// Parts of the file that are not modelled give a warning if they change the motion, otherwise a note. All of
/// them are "not_modelled" in the JSON answer: {"changes_motion": [...], "other": [...]}.
Result<ModelFile> read_model(const Command& command, const std::string& path, const ModelOptions& options);
/// As read_model, for verbs that write pages: the scene knows its file by the name that output files use, and a
/// scene without a name has that of its file.
Result<ModelFile> read_model_for_pages(const Command& command, const std::string& path,
                                       const ModelOptions& options);

/// Prefixes an error of the engine with the scene's file, unless the error names the file already.
tl::unexpected<Error> in_file(const std::string& file, Error error);

}  // namespace borelli
