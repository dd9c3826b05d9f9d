#include "pipeline/whole_file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

namespace borelli {

namespace fs = std::filesystem;

namespace {

// Partial files that are being written now. Plain bytes at a fixed place, so that a signal's handler may read
// them: it must not lock or allocate.
struct Slot {
  std::atomic<bool> taken{false}, ready{false};
  std::atomic<pid_t> thread{0};
  std::array<char, PATH_MAX> path{};
};
std::array<Slot, 16> slots;
std::atomic<bool> stopped{false};

class Noted {
 public:
  explicit Noted(const std::string& path) {
    if (path.size() >= PATH_MAX) return;
    for (Slot& slot : slots) {
      if (slot.taken.exchange(true)) continue;
      std::memcpy(slot.path.data(), path.c_str(), path.size() + 1);
      slot.thread = gettid();
      slot.ready = true;
      slot_ = &slot;
      return;
    }
  }
  ~Noted() { forget(); }
  void forget() {
    if (!slot_) return;
    slot_->ready = false;
    slot_->taken = false;
    slot_ = nullptr;
  }
  Noted(const Noted&) = delete;
  Noted& operator=(const Noted&) = delete;

 private:
  Slot* slot_ = nullptr;
};

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// what a file of that name is called until it is whole
std::string partial_name(const std::string& name) {
  return ".partial-" + std::to_string(getpid()) + "-" + name;
}

// what stands against a file of that name in `folder`, "" where nothing does
std::string obstacle(const fs::path& folder, const std::string& name) {
  std::error_code problem;
  std::vector<fs::path> missing;
  fs::path there = folder;
  for (; !fs::exists(there, problem) && there != folder_of(there); there = folder_of(there))
    missing.push_back(there);
  if (!fs::is_directory(there, problem)) return there.string() + " is not a folder";
  std::vector<fs::path> made;
  std::string found;
  for (auto next = missing.rbegin(); next != missing.rend() && found.empty(); ++next) {
    if (fs::create_directory(*next, problem)) made.push_back(*next);
    if (problem) found = "the folder " + next->string() + " cannot be made: " + problem.message();
  }
  if (found.empty()) {
    const fs::path probe = folder / partial_name(name);
    const int file = open(probe.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    if (file < 0)
      found = "the folder " + folder.string() + ": " + std::strerror(errno);
    else
      close(file), unlink(probe.c_str());
  }
  for (auto last = made.rbegin(); last != made.rend(); ++last) rmdir(last->c_str());
  return found;
}

Result<void> check_no_folder(const fs::path& path) {
  std::error_code problem;
  if (fs::is_directory(path, problem))
    return bad_use(path.string(), "is a folder, expected the name of a file to write");
  return {};
}

}  // namespace

void stop_writing() noexcept {
  stopped = true;
  // a thread that is noted and has not opened its file yet had not seen that: the file is waited for
  std::array<bool, slots.size()> removed{};
  for (int waited = 0; waited < 500; ++waited) {  // ms
    bool missing = false;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      if (!slots[i].ready) continue;
      removed[i] = unlink(slots[i].path.data()) == 0 || removed[i];
      missing = missing || (!removed[i] && slots[i].thread != gettid());
    }
    if (!missing) return;
    poll(nullptr, 0, 1);
  }
}

Result<void> check_writable(const fs::path& path, const std::vector<fs::path>& inputs) {
  if (auto fine = check_no_folder(path); !fine) return fine;
  std::error_code absent;
  for (const fs::path& input : inputs)
    if (fs::equivalent(path, input, absent))
      return bad_use(path.string(), "is what this command reads; name another file");
  if (const std::string found = obstacle(folder_of(path), path.filename().string()); !found.empty())
    return failure(path.string(), "cannot be written: " + found);
  return {};
}

Result<void> check_folder_writable(const fs::path& folder, const std::vector<std::string>& names) {
  if (const std::string found = obstacle(folder, "probe"); !found.empty())
    return failure(folder.string(), "cannot be written to: " + found);
  for (const std::string& name : names)
    if (auto fine = check_no_folder(folder / name); !fine) return fine;
  return {};
}

Result<void> write_whole(const fs::path& path, const std::function<Result<void>(const fs::path&)>& write) {
  if (auto fine = check_no_folder(path); !fine) return fine;
  std::error_code problem;
  const fs::path folder = folder_of(path);
  fs::create_directories(folder, problem);
  if (problem) return failure(folder.string(), "cannot make this folder: " + problem.message());

  // hidden, so that a person does not take it for a result; the extension stays, since writers choose by it
  const fs::path beside = folder / partial_name(path.filename().string());
  Noted noted(beside.string());
  if (stopped) {
    noted.forget();
    for (;;) pause();  // until the program ends
  }
  auto done = write(beside);
  if (done) {
    fs::rename(beside, path, problem);
    if (problem) done = failure(path.string(), "cannot put the file in place: " + problem.message());
  }
  if (done) return done;
  fs::remove(beside, problem);
  Error error = done.error();  // tells of the file that was asked for, not of the one beside it
  for (std::string* text : {&error.where, &error.what}) replace_all(*text, beside.string(), path.string());
  return tl::unexpected(std::move(error));
}

Result<void> write_whole(const fs::path& path, std::string_view bytes) {
  return write_whole(path, [&](const fs::path& beside) { return write_bytes(beside, bytes); });
}

Result<void> write_bytes(const fs::path& path, std::string_view bytes) {
  const auto complain = [&] {
    return failure(path.string(), std::string("cannot be written: ") + std::strerror(errno));
  };
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) return complain();
  if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size() || std::fflush(file) != 0) {
    auto problem = complain();
    std::fclose(file);
    return problem;
  }
  if (std::fclose(file) != 0) return complain();
  return {};
}

}  // namespace borelli
