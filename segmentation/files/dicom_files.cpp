#include "segmentation/files/dicom_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>
#include <utility>

#include "error/printable.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t dicom_preamble = 132;  // 128 bytes and "DICM"

bool holds_folder(const fs::path& outer, const fs::path& inner) {
  return std::ranges::mismatch(outer, inner).in1 == outer.end();
}

// Lists a folder and the folders in it.
void list_folder(const fs::path& folder, const fs::path& root, std::set<fs::path>& seen, FolderFiles& found,
                 std::error_code& trouble) {
  std::vector<fs::path> entries;
  for (auto it = fs::directory_iterator(folder, trouble); !trouble && it != fs::directory_iterator();
       it.increment(trouble))
    entries.push_back(it->path());
  std::ranges::sort(entries);
  for (const fs::path& path : entries) {
    if (trouble) return;
    std::error_code ignored;
    const auto status = fs::status(path, ignored);
    if (path.filename().string().starts_with("._")) {
      found.placeholders.macos_metadata.push_back(path.string());
    } else if (status.type() == fs::file_type::not_found) {
      found.placeholders.unfetched.push_back(path.string());
    } else if (status.type() == fs::file_type::regular) {
      found.files.push_back(path.string());
    } else if (status.type() == fs::file_type::directory) {
      const fs::path real = fs::canonical(path, trouble);
      if (!trouble && !holds_folder(real, root) && seen.insert(real).second)
        list_folder(path, root, seen, found, trouble);
    }
  }
}

}  // namespace

std::string kind_without_series(const DicomElements& object) {
  // by the start of the SOP class (PS3.4, B.5), the longest first
  static constexpr std::array<std::pair<std::string_view, const char*>, 15> kinds{{
      {"1.2.840.10008.1.3.10", "a directory of DICOM files (DICOMDIR)"},
      {"1.2.840.10008.5.1.4.1.1.481.2", "an RT dose"},
      {"1.2.840.10008.5.1.4.1.1.481.3", "an RT structure set"},
      {"1.2.840.10008.5.1.4.1.1.481.5", "an RT plan"},
      {"1.2.840.10008.5.1.4.1.1.481.8", "an RT ion plan"},
      {"1.2.840.10008.5.1.4.1.1.88.59", "a selection of key objects"},
      {"1.2.840.10008.5.1.4.1.1.88.", "a structured report"},
      {"1.2.840.10008.5.1.4.1.1.104.", "an encapsulated document"},
      {"1.2.840.10008.5.1.4.1.1.11.", "a presentation state"},
      {"1.2.840.10008.5.1.4.1.1.66.1", "a registration"},
      {"1.2.840.10008.5.1.4.1.1.66.2", "a set of fiducials"},
      {"1.2.840.10008.5.1.4.1.1.66.3", "a deformable registration"},
      {"1.2.840.10008.5.1.4.1.1.66.5", "a surface segmentation"},
      {"1.2.840.10008.5.1.4.1.1.67", "a real world value mapping"},
      {"1.2.840.10008.5.1.4.1.1.9.", "a waveform"},
  }};
  const std::string sop_class = object.text(0x00080016), modality = object.text(0x00080060);
  for (const auto& [start, kind] : kinds)
    if (sop_class.starts_with(start)) return kind;
  if (modality == "RTDOSE") return "an RT dose";
  if (object.pixel_offset > 0) return "";
  return modality.empty() ? "a DICOM file without an image"
                          : fmt::format("a DICOM file without an image (modality {})", printable(modality));
}

std::string files_sentence(const std::vector<std::string>& paths, std::string_view one,
                           std::string_view many) {
  const std::string first = fs::path(paths.front()).filename().string();
  return paths.size() == 1 ? fmt::format("{} {}", first, one)
                           : fmt::format("{} files (the first is {}) {}", paths.size(), first, many);
}

bool Placeholders::add_if_placeholder(const std::string& path) {
  std::array<char, dicom_preamble + 1> start{};
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), start.size());
  const std::string_view text(start.data(), static_cast<std::size_t>(file.gcount()));
  if (text.starts_with("version https://git-lfs") || text.starts_with("/annex/objects/") ||
      text.find(".git/annex/objects/") != std::string_view::npos)
    unfetched.push_back(path);
  else if (text.empty() || (text.size() == dicom_preamble && text.ends_with("DICM")))
    stubs.push_back(path);
  else
    return false;
  return true;
}

std::vector<std::string> Placeholders::sentences() const {
  std::vector<std::string> all;
  if (!unfetched.empty())
    all.push_back(files_sentence(unfetched, "points", "point") +
                  " to content that has not been downloaded (git-annex, Git LFS or a broken link); fetch it "
                  "with 'datalad "
                  "get', 'git annex get' or 'git lfs pull'");
  if (!stubs.empty())
    all.push_back(files_sentence(stubs, "holds", "hold") + " only the start of a DICOM file");
  if (!macos_metadata.empty())
    all.push_back(files_sentence(macos_metadata, "holds", "hold") + " macOS metadata (._*) and no image");
  return all;
}

Result<FolderFiles> files_below(const std::string& folder) {
  FolderFiles found;
  std::error_code trouble;
  if (fs::is_regular_file(folder, trouble)) {
    found.files.push_back(folder);
    return found;
  }
  const fs::path root = fs::canonical(folder, trouble);
  std::set<fs::path> seen{root};
  if (!trouble) list_folder(folder, root, seen, found, trouble);
  if (trouble) return bad_use(folder, "cannot be listed: " + trouble.message());
  std::ranges::sort(found.files);
  return found;
}

}  // namespace borelli
