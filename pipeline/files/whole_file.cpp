#include "pipeline/files/whole_file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

namespace borelli {

namespace fs = std::filesystem;

namespace {

// Partial files being written now, as plain bytes at a fixed address: a signal handler reads them and must
// not lock or allocate.
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

constexpr std::string_view partial_prefix = ".partial-";

// temporary name of a file while it is written
std::string partial_name(const std::string& name) {
  return std::string(partial_prefix) + std::to_string(getpid()) + "-" + name;
}

// Shared lock on a folder while a file in it is written. It also shows a living writer to programs that
// cannot see its process (another container, another machine with the same disk).
class WriterInFolder {
 public:
  explicit WriterInFolder(const fs::path& folder)
      : file_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (file_ >= 0) flock(file_, LOCK_SH | LOCK_NB);
  }
  ~WriterInFolder() {
    if (file_ >= 0) close(file_);
  }
  WriterInFolder(const WriterInFolder&) = delete;
  WriterInFolder& operator=(const WriterInFolder&) = delete;

 private:
  int file_;
};

// Process number in ".partial-PROCESS-NAME", with NAME as `target`; 0 for other names.
pid_t writer_of(std::string_view name, std::string_view& target) {
  if (!name.starts_with(partial_prefix)) return 0;
  name.remove_prefix(partial_prefix.size());
  pid_t process = 0;
  const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), process);
  if (problem != std::errc() || process <= 0 || end == name.data() + name.size() || *end != '-') return 0;
  target = name.substr(static_cast<std::size_t>(end + 1 - name.data()));
  return process;
}

// Removes partial files in `folder` (not below) whose writers have ended: of one target, or of all ("").
void sweep_folder(const fs::path& folder, std::string_view of_target) {
  std::error_code problem, ignored;
  std::vector<std::pair<fs::path, pid_t>> found;
  for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    std::string_view target;
    const pid_t writer = writer_of(name, target);
    if (writer == 0 || (!of_target.empty() && target != of_target) || entry->is_symlink(problem)) continue;
    if (writer == getpid() || (kill(writer, 0) != 0 && errno == ESRCH))
      found.emplace_back(entry->path(), writer);
  }
  if (found.empty()) return;
  const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  const bool nobody_writes = flock(file, LOCK_EX | LOCK_NB) == 0;
  const bool no_locks_here = !nobody_writes && errno != EWOULDBLOCK;
  for (const auto& [partial, writer] : found)
    if (nobody_writes || (no_locks_here && writer != getpid())) fs::remove_all(partial, ignored);
  close(file);
}

// Flushes a file or folder to the disk.
Result<void> sync(const fs::path& path, bool folder = false) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | (folder ? O_DIRECTORY : 0));
  if (file < 0 && (folder || errno == EACCES)) return {};  // no permission to read it
  if (file < 0) return failure(path.string(), std::string("cannot be read again: ") + std::strerror(errno));
  const int answer = fsync(file), reason = errno;
  close(file);
  if (answer == 0 || reason == EINVAL || reason == ENOTSUP) return {};  // unsupported by some file systems
  return failure(path.string(), std::string("cannot be flushed to the disk: ") + std::strerror(reason));
}

// The error with the final path instead of the temporary one.
tl::unexpected<Error> named(Error error, const fs::path& beside, const fs::path& path) {
  for (std::string* text : {&error.where, &error.what}) replace_all(*text, beside.string(), path.string());
  return tl::unexpected(std::move(error));
}

// The path itself if it exists, else the nearest of its parents that does; and what is missing below it,
// the deepest first.
struct Place {
  fs::path there;
  std::vector<fs::path> missing;
};

Place place_of(const fs::path& path) {
  std::error_code problem;
  Place place{path, {}};
  while (!fs::exists(place.there, problem) && place.there != folder_of(place.there)) {
    place.missing.push_back(place.there);
    place.there = folder_of(place.there);
  }
  return place;
}

std::string not_created(const fs::path& folder, const std::string& why) {
  return "the folder " + folder.string() + " cannot be created: " + why;
}

// Creates a folder and its missing parents. Removes those it created, if they are empty, unless kept.
class NewFolders {
 public:
  explicit NewFolders(const fs::path& folder) {
    std::error_code problem;
    const auto [there, missing] = place_of(folder);
    if (!fs::is_directory(there, problem)) problem_ = there.string() + " is not a folder";
    for (auto next = missing.rbegin(); next != missing.rend() && problem_.empty(); ++next) {
      if (fs::create_directory(*next, problem)) made_.push_back(*next);
      if (problem) problem_ = not_created(*next, problem.message());
    }
  }
  ~NewFolders() {
    for (auto last = made_.rbegin(); last != made_.rend(); ++last) rmdir(last->c_str());
  }
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;

  void keep() { made_.clear(); }
  // why the folder could not be created; "" if it is there
  const std::string& problem() const { return problem_; }

 private:
  std::vector<fs::path> made_;  // parents first
  std::string problem_;
};

// What prevents a file of that name in `folder`; "" if nothing does. If the folder is missing, the file is
// tried in the nearest one above it: a folder created for the trial could be removed while another program
// uses it.
std::string obstacle(const fs::path& folder, const std::string& name) {
  const auto [there, missing] = place_of(folder);
  std::error_code problem;
  if (!fs::is_directory(there, problem)) return there.string() + " is not a folder";
  if (!missing.empty() && fs::is_symlink(missing.back(), problem))
    return not_created(missing.back(), "it is a link to a place that does not exist");
  const fs::path probe = there / partial_name(name);
  const int file = open(probe.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) {
    const std::string why = std::strerror(errno);
    return missing.empty() ? "the folder " + there.string() + ": " + why : not_created(missing.back(), why);
  }
  close(file), unlink(probe.c_str());
  return "";
}

Result<void> check_no_folder(const fs::path& path) {
  std::error_code problem;
  if (fs::is_directory(path, problem)) return bad_use(path.string(), "is a folder; name a file to write");
  return {};
}

}  // namespace

void stop_writing() noexcept {
  stopped = true;
  // a thread may have registered its file before the stop and not opened it yet: wait for the file
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
      return bad_use(path.string(), "is an input of this command; name another file");
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
  NewFolders folders(folder);
  if (!folders.problem().empty()) return failure(path.string(), "cannot be written: " + folders.problem());
  sweep_partial_files(path);
  const WriterInFolder writer(folder);

  // hidden, so that nobody takes it for a result; with the same extension, since writers choose the format by
  // it
  const fs::path beside = folder / partial_name(path.filename().string());
  Noted noted(beside.string());
  if (stopped) {
    noted.forget();
    for (;;) pause();  // until the program ends
  }
  auto done = write(beside);
  if (done) done = sync(beside);
  if (done) {
    fs::rename(beside, path, problem);
    if (problem) done = failure(path.string(), "cannot be moved to its final name: " + problem.message());
  }
  if (done) {
    folders.keep();
    return sync(folder, true);
  }
  fs::remove(beside, problem);
  return named(done.error(), beside, path);
}

Result<void> write_whole_set(const fs::path& folder, const std::vector<std::string>& names,
                             const std::function<Result<void>(const fs::path&)>& write) {
  const fs::path beside = folder / partial_name(names.front());
  sweep_partial_files(folder / names.front());
  std::error_code problem, ignored;
  fs::remove_all(beside, ignored);
  NewFolders folders(folder);
  if (!folders.problem().empty())
    return failure(folder.string(), "cannot be written to: " + folders.problem());
  const WriterInFolder writer(folder);
  fs::create_directory(beside, problem);
  if (problem) return failure(folder.string(), "cannot be written to: " + problem.message());
  auto done = write(beside);
  for (const std::string& name : names)
    if (done) done = sync(beside / name);
  for (const std::string& name : names) {
    if (!done) break;
    fs::rename(beside / name, folder / name, problem);
    if (problem) done = failure((folder / name).string(), "cannot be written: " + problem.message());
  }
  fs::remove_all(beside, ignored);
  if (done) {
    folders.keep();
    return sync(folder, true);
  }
  return named(done.error(), beside, folder);
}

void sweep_partial_files(const fs::path& path) { sweep_folder(folder_of(path), path.filename().string()); }

void sweep_partial_files_below(const fs::path& folder) {
  // each folder with an iterator of its own: another program may remove one meanwhile, and that must not end
  // the sweep of the others
  std::vector<fs::path> left{folder};
  while (!left.empty()) {
    const fs::path one = std::move(left.back());
    left.pop_back();
    sweep_folder(one, "");
    std::error_code problem, vanished;
    for (fs::directory_iterator entry(one, problem), end; !problem && entry != end; entry.increment(problem))
      if (!entry->is_symlink(vanished) && entry->is_directory(vanished)) left.push_back(entry->path());
  }
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
