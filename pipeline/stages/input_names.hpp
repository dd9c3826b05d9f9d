// How inputs are named in outputs: by their files' names. The folder that they lie in often bears a patient's
// name, and outputs are shared.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace borelli {

/// Of the flag --keep-paths.
inline constexpr const char* keep_paths_help =
    "Write inputs' paths into outputs (without it their files' names alone: a folder often bears a "
    "patient's)";

class InputNames {
 public:
  /// `paths`: of files and folders, as the user gave them; those that are not there are left as they are.
  /// `keep_paths`: everything is.
  InputNames(bool keep_paths, const std::vector<std::string>& paths);

  /// A file's name; "DICOM folder" for a folder.
  std::string name_of(const std::string& path) const;
  /// Text with the inputs' names in place of their paths, and without the folders of the files beside them.
  std::string without_folders(std::string text) const;
  /// The same of all texts in it.
  nlohmann::json without_folders(nlohmann::json value) const;

 private:
  bool keep_paths_;
  std::vector<std::pair<std::string, std::string>> names_;  // in place of what; the longest first
};

}  // namespace borelli
