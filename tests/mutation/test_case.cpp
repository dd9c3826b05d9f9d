#include "tests/mutation/test_case.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

namespace borelli::mutation {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view before_name = "==> ", after_name = " <==\n";
constexpr std::size_t most_files = 16;

std::string mended_name(std::string_view name) {
  std::string out;
  for (const char c : name.substr(0, 40))
    out += std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-' ? c : '_';
  return out.empty() || out.front() == '.' ? "file" + out : out;
}

void sort_by_name(TestCase& test) {
  std::ranges::stable_sort(test.files, {}, &TestFile::name);
  if (test.files.empty()) test.files.push_back({"file", ""});
}

}  // namespace

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_case(const TestCase& test, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const TestFile& file : test.files)
    std::ofstream(folder / file.name, std::ios::binary) << file.on_disk();
}

TestCase read_case(const fs::path& path) {
  TestCase test{path.filename().string(), {}};
  if (!fs::is_directory(path)) {
    test.files.push_back({path.filename().string(), bytes_of(path)});
    return test;
  }
  for (const auto& entry : fs::directory_iterator(path))
    if (entry.is_regular_file())
      test.files.push_back({entry.path().filename().string(), bytes_of(entry.path())});
  sort_by_name(test);
  return test;
}

std::string joined(const TestCase& test) {
  std::string out;
  for (const TestFile& file : test.files)
    out.append(before_name).append(file.name).append(after_name).append(file.on_disk()).append("\n");
  return out;
}

TestCase parted(std::string_view text) {
  TestCase test;
  while (!text.empty() && test.files.size() < most_files) {
    std::string_view name = "file";
    if (text.starts_with(before_name)) {
      const auto end = text.find(after_name);
      const auto length = end == text.npos ? text.size() : end + after_name.size();
      name = text.substr(before_name.size(), std::min(end, text.size()) - before_name.size());
      text.remove_prefix(length);
    }
    const auto next = text.find("\n==> ");
    const auto end = next == text.npos ? text.size() - text.ends_with('\n') : next;
    test.files.push_back({mended_name(name), std::string(text.substr(0, end))});
    text.remove_prefix(next == text.npos ? text.size() : next + 1);
  }
  sort_by_name(test);
  return test;
}

}  // namespace borelli::mutation
