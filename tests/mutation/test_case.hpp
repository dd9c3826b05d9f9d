// An input of a reader: one file or several, of which the first by name is the one to read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace borelli::mutation {

struct TestFile {
  std::string name, bytes;
  /// What packs `bytes` on their way to the disk (gzip, a checksum), where a mutation of what is packed goes
  /// deeper than one of the packed; null: nothing does.
  std::string (*pack)(const std::string& bytes) = nullptr;

  std::string on_disk() const { return pack ? pack(bytes) : bytes; }
};

struct TestCase {
  std::string name;             ///< fit for a file's name
  std::vector<TestFile> files;  ///< the first by name first
  bool may_be_refused = false;  ///< a seed of a kind that need not be read
};

/// Writes the files into a folder, which is made anew.
void write_case(const TestCase& test, const std::filesystem::path& folder);

/// A file, or all files of a folder, as a case of that name.
TestCase read_case(const std::filesystem::path& path);

/// All files in one text for libFuzzer: "==> NAME <==" before each.
std::string joined(const TestCase& test);
/// The same back, of any bytes. Names are mended: no folders, nothing hidden.
TestCase parted(std::string_view text);

std::string bytes_of(const std::filesystem::path& path);

}  // namespace borelli::mutation
