#include "pipeline/files/input_names.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace borelli {
namespace {

namespace fs = std::filesystem;

constexpr const char* folder_name = "DICOM folder";

std::string without_slashes_at_end(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

bool is_word_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; }

// Whether `path`, at [begin, end) of `text`, is a whole path or the leading folders of one, not part of a
// word.
bool is_whole_path(const std::string& text, std::size_t begin, std::size_t end, const std::string& path) {
  const char before = begin > 0 ? text[begin - 1] : ' ', after = end < text.size() ? text[end] : ':';
  if (is_word_letter(before) || before == '/' || before == '.') return false;
  if (path.back() == '/') return true;
  // a path without a slash may be any word: it counts only as the "where" of a message, "path: ..."
  return path.find('/') == path.npos ? begin == 0 && after == ':' : !is_word_letter(after);
}

}  // namespace

InputNames::InputNames(bool keep_paths, const std::vector<std::string>& paths) : keep_paths_(keep_paths) {
  if (keep_paths) return;
  for (const std::string& given : paths) {
    std::error_code problem;
    if (given.empty() || !fs::exists(given, problem)) continue;
    const std::string name = name_of(given);
    const fs::path absolute = fs::absolute(given, problem), canonical = fs::weakly_canonical(given, problem);
    for (const fs::path& form : {fs::path(given), absolute, canonical}) {
      const fs::path path = without_slashes_at_end(form.string());
      names_.emplace_back(path.string(), name);
      const std::string folder = (fs::is_directory(path, problem) ? path : path.parent_path()).string();
      if (folder.size() > 1) names_.emplace_back(folder + '/', "");
    }
  }
  std::ranges::stable_sort(names_, std::ranges::greater{}, [](const auto& n) { return n.first.size(); });
}

std::string InputNames::name_of(const std::string& path) const {
  std::error_code problem;
  if (keep_paths_ || path.empty()) return path;
  return fs::is_directory(path, problem) ? folder_name : fs::path(path).filename().string();
}

std::string InputNames::without_folders(std::string text) const {
  for (const auto& [path, name] : names_)
    for (std::size_t at = 0; (at = text.find(path, at)) != text.npos;)
      if (is_whole_path(text, at, at + path.size(), path)) {
        text.replace(at, path.size(), name);
        at += name.size();
      } else {
        ++at;
      }
  return text;
}

nlohmann::json InputNames::without_folders(nlohmann::json value) const {
  if (value.is_string()) return without_folders(value.get<std::string>());
  if (value.is_structured())
    for (auto& entry : value) entry = without_folders(std::move(entry));
  return value;
}

}  // namespace borelli
