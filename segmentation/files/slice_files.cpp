#include "segmentation/files/slice_files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>

#include "error/printable.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

// A file name with one number, as by printf's %d, %3d or %03d (a user's text must never reach printf).
struct Pattern {
  std::string before, after;
  std::size_t width = 0;
  char fill = ' ';

  std::string name(std::int64_t number) const {
    std::string digits = std::to_string(number);
    if (digits.size() < width) digits.insert(0, width - digits.size(), fill);
    return before + digits + after;
  }
};

std::optional<Pattern> pattern_in(std::string_view word) {
  const auto percent = word.find('%');
  if (percent == std::string_view::npos) return std::nullopt;
  Pattern pattern{std::string(word.substr(0, percent)), {}};
  std::size_t at = percent + 1;
  if (at < word.size() && word[at] == '0') pattern.fill = '0', ++at;
  for (; at < word.size() && std::isdigit(static_cast<unsigned char>(word[at])) && pattern.width < 100; ++at)
    pattern.width = 10 * pattern.width + static_cast<std::size_t>(word[at] - '0');
  if (at >= word.size() || std::string_view("diu").find(word[at]) == std::string_view::npos)
    return std::nullopt;
  pattern.after = word.substr(at + 1);
  if (pattern.after.find('%') != std::string::npos || pattern.width > 20) return std::nullopt;
  return pattern;
}

Result<std::vector<std::string>> by_pattern(const std::string& path, std::string_view field,
                                            std::int64_t slices) {
  const auto blank = field.find_first_of(" \t");
  const auto pattern = pattern_in(field.substr(0, blank));
  const auto numbers = numbers_in(blank == std::string_view::npos ? std::string_view{} : field.substr(blank));
  const auto number = [&](std::size_t n, double otherwise) {
    return whole_number(numbers && n < numbers->size() && std::isfinite((*numbers)[n]) ? (*numbers)[n]
                                                                                       : otherwise);
  };
  const std::int64_t first = number(0, 1), step = number(2, 1),
                     last = number(1, static_cast<double>(first + slices - 1));
  if (!pattern || !numbers || step == 0)
    return failure(path, fmt::format("gives '{}' as the pattern of its slice files; expected one like "
                                     "'slice%03d.raw 1 {} 1' (first number, last, step)",
                                     printable(field), slices));
  std::vector<std::string> files;
  for (std::int64_t n = first; step > 0 ? n <= last : n >= last; n += step) {
    if (std::ssize(files) == slices)
      return failure(path, fmt::format("has {} slices, but its pattern '{}' names more files", slices,
                                       printable(field)));
    files.push_back(pattern->name(n));
  }
  return files;
}

// Offset in the file behind its first `count` lines.
Result<std::uint64_t> after_lines(const VoxelFile& file, double count) {
  if (count == 0) return file.offset;
  double seen = 0;
  const auto text = read_header_text(file.path, [&](std::string_view) { return ++seen == count; });
  if (!text) return tl::unexpected(text.error());
  return text->end;
}

}  // namespace

bool names_follow(std::string_view field) { return field.substr(0, field.find_first_of(" \t")) == "LIST"; }

Result<std::vector<std::string>> named_files(const std::string& path, std::string_view field,
                                             const std::vector<std::string>& lines, std::int64_t slices) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code ignored;
  std::vector<std::string> files;
  if (names_follow(field)) {
    for (const std::string& line : lines)
      if (const auto name = trimmed(line); !name.empty()) files.emplace_back(name);
  } else if (field.find('%') != std::string_view::npos && !fs::exists(folder / field, ignored)) {
    auto made = by_pattern(path, field, slices);
    if (!made) return made;
    files = std::move(*made);
  } else {
    files.emplace_back(field);
  }
  if (files.empty() || slices % std::ssize(files) != 0)
    return failure(
        path,
        fmt::format(
            "names {} files for {} slices; expected one file per slice, or equally many slices per file",
            files.size(), slices));
  for (std::string& file : files) {
    file = (folder / file).string();
    if (!fs::exists(file, ignored))
      return bad_use(
          path, fmt::format("refers to the voxel file '{}', which does not exist; put it beside the header",
                            printable(file, 300)));
  }
  return files;
}

Result<void> set_voxel_files(ImageHeader& header, const std::vector<std::string>& files,
                             const BeforeVoxels& before) {
  const std::uint64_t bytes = header.grid.count() * static_cast<std::uint64_t>(header.layers) *
                              scalar_bytes(header.scalar) / files.size();
  std::vector<VoxelFile> found;
  for (const std::string& path : files) {
    VoxelFile file{path, path == header.data_file ? header.file_offset : 0};
    const auto start = after_lines(file, before.lines);
    if (!start) return tl::unexpected(start.error());
    file.offset = *start + before.bytes;
    if (before.all_else) {
      const auto source = ByteSource::open(path, ByteSource::Packing::plain);
      if (!source) return tl::unexpected(source.error());
      if (source->file_size() < bytes)
        return failure(path, fmt::format("is cut off: its header states {} bytes of voxels, but it has {}",
                                         bytes, source->file_size()));
      file.offset = source->file_size() - bytes;
    }
    found.push_back(std::move(file));
  }
  header.data_file = found.front().path, header.file_offset = found.front().offset;
  if (found.size() > 1) header.slice_files = std::move(found);
  return {};
}

}  // namespace borelli
