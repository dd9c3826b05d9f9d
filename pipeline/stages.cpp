#include "pipeline/stages.hpp"

#include <fmt/core.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <map>
#include <memory>

#include "pipeline/whole_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Digest {
 public:
  Digest() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> raw;
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), raw.data(), &size);
    std::string text;
    for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", raw[i]);
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

Result<void> add_file(Digest& digest, const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> buffer(1 << 20);
  while (file) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    digest.add({buffer.data(), static_cast<std::size_t>(file.gcount())});
  }
  if (!file.eof()) return failure(path.string(), "cannot be read");
  return {};
}

// the kernel's high-water mark of resident memory; writing 5 to clear_refs starts it anew (proc(5))
void restart_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

// what a run that was killed left behind under hidden names
void sweep_partial_files(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> stale;
  for (const auto& entry : fs::recursive_directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with(".partial-")) stale.push_back(entry.path());
  for (const auto& path : stale) fs::remove_all(path, ignored);
}

// Files and their sizes as run.json records them: a missing, emptied or cut file is no result.
Result<json> outputs_of(const Stage& stage, const json& answer, const fs::path& folder) {
  std::vector<std::string> files = stage.outputs;
  if (answer.contains("files")) files = answer["files"].get<std::vector<std::string>>();
  json outputs = json::object();
  for (const auto& file : files) {
    std::error_code problem;
    const auto bytes = fs::file_size(folder / file, problem);
    if (problem) return failure(stage.name, "left no " + (folder / file).string());
    outputs[file] = bytes;
  }
  return outputs;
}

bool is_done(const json& record, const std::string& key, const fs::path& folder) {
  if (!record.is_object() || record.value("key", "") != key || !record["outputs"].is_object()) return false;
  for (const auto& [file, bytes] : record["outputs"].items()) {
    std::error_code problem;
    if (fs::file_size(folder / file, problem) != bytes || problem) return false;
  }
  return true;
}

}  // namespace

std::string digest_of_bytes(std::string_view bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.hex();
}

Result<std::string> digest_of(const fs::path& path) {
  Digest digest;
  std::error_code problem;
  if (!fs::exists(path, problem)) return bad_use(path.string(), "no such file or folder");
  if (!fs::is_directory(path, problem)) {
    if (auto added = add_file(digest, path); !added) return tl::unexpected(added.error());
    return digest.hex();
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path, problem))
    if (entry.is_regular_file(problem)) files.push_back(entry.path());
  std::ranges::sort(files);
  for (const auto& file : files) {
    digest.add(file.lexically_relative(path).string());
    if (auto added = add_file(digest, file); !added) return tl::unexpected(added.error());
  }
  return digest.hex();
}

Result<json> run_stages(const FolderLock& lock, const json& head, const std::vector<Stage>& stages,
                        bool force, const StageObserver& observer) {
  const fs::path& folder = lock.folder();
  for (const Stage& stage : stages)
    for (const std::string& output : stage.outputs)
      if (auto fine = check_writable(folder / output); !fine) return tl::unexpected(fine.error());
  const fs::path record_path = folder / "run.json";
  json before;
  if (fs::exists(record_path) && !force) {
    const auto bytes = read_whole(record_path);
    if (!bytes) return tl::unexpected(bytes.error());
    before = json::parse(*bytes, nullptr, false);
    if (!before.is_object())
      return failure(record_path.string(), "is no run's record; remove it or use --force");
  }
  sweep_partial_files(folder);

  json record = head;
  record["stages"] = json::array();
  std::map<std::string, std::string> keys;
  for (const Stage& stage : stages) {
    json identity = {{"stage", stage.name},
                     {"settings", stage.settings},
                     {"inputs", head.value("inputs", json())},
                     {"program", head.value("program", "")}};
    for (const auto& need : stage.needs) identity["needs"].push_back(keys.at(need));
    const std::string key = keys[stage.name] = digest_of_bytes(identity.dump());

    json past;
    if (before.contains("stages"))
      for (const auto& entry : before["stages"])
        if (entry.is_object() && entry.value("stage", "") == stage.name) past = entry;
    if (is_done(past, key, folder)) {
      record["stages"].push_back(past);
      observer.skipped(stage);
      continue;
    }

    observer.begins(stage);
    restart_peak_memory();
    const auto began = std::chrono::steady_clock::now();
    auto answer = stage.work(observer.progress, record);
    if (!answer) return tl::unexpected(answer.error());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    const auto outputs = outputs_of(stage, *answer, folder);
    if (!outputs) return tl::unexpected(outputs.error());

    json entry = {{"stage", stage.name}, {"seconds", seconds},         {"peak_memory_mib", peak_memory_mib()},
                  {"outputs", *outputs}, {"settings", stage.settings}, {"key", key}};
    answer->erase("files");
    entry.update(*answer);
    record["stages"].push_back(entry);
    if (auto written = write_whole(record_path, record.dump(2) + "\n"); !written)
      return tl::unexpected(written.error());
    observer.ends(stage, seconds);
  }
  if (auto written = write_whole(record_path, record.dump(2) + "\n"); !written)
    return tl::unexpected(written.error());
  return record;
}

}  // namespace borelli
