// Names inputs in outputs by their file names alone: outputs are shared, and a folder is often named after
// the patient.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace borelli {

/// Help of the flag --keep-paths.
inline constexpr const char* keep_paths_help =
    "Write the full paths of inputs into the outputs (default: file names only, since folders are often "
    "named after the patient)";

class InputNames {
 public:
  /// `paths`: files and folders as the user gave them; missing ones are ignored. `keep_paths`: texts stay
  /// unchanged.
  InputNames(bool keep_paths, const std::vector<std::string>& paths);

  /// A file's name; "DICOM folder" for a folder.
  std::string name_of(const std::string& path) const;
  /// Replaces each input's path in a text by its name, and removes the inputs' folders from other paths.
  std::string without_folders(std::string text) const;
  /// The same for every text in a JSON value.
  nlohmann::json without_folders(nlohmann::json value) const;

 private:
  bool keep_paths_;
  std::vector<std::pair<std::string, std::string>> names_;  // path and its replacement; longest path first
};

}  // namespace borelli
