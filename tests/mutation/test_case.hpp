// An input of a reader: one or several files, of which the first is read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace borelli::mutation {

struct TestFile {
  std::string name, bytes;
  /// Packs `bytes` on the way to the disk (gzip, a checksum), so that mutations reach what is packed. Null:
  /// no packing.
  std::string (*pack)(const std::string& bytes) = nullptr;

  std::string on_disk() const { return pack ? pack(bytes) : bytes; }
};

struct TestCase {
  std::string name;             ///< valid as a file name
  std::vector<TestFile> files;  ///< the file to read comes first
  bool may_be_refused = false;  ///< a seed that readers need not accept
};

/// Empties `folder` and writes the files into it.
void write_case(const TestCase& test, const std::filesystem::path& folder);

/// A file, or all files of a folder sorted by name, as a case.
TestCase read_case(const std::filesystem::path& path);

/// All files in one text for libFuzzer: "==> NAME <==" before each.
std::string joined(const TestCase& test);
/// Inverse of joined(), for any bytes. Makes names safe: no folders, no hidden files.
TestCase parted(std::string_view text);

std::string bytes_of(const std::filesystem::path& path);

}  // namespace borelli::mutation
