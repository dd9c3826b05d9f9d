#include "process/program_pipe.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

namespace borelli {
namespace {

// Runs in the child; only calls that are safe after a fork of a process with threads. The errno of a failed
// exec goes to `report`.
[[noreturn]] void become(char* const* words, int input, int errors, int report, pid_t parent) {
  setsid();  // not in the terminal's group
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_DFL);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(input, STDIN_FILENO), dup2(nowhere, STDOUT_FILENO), dup2(errors, STDERR_FILENO);
  execvp(words[0], words);
  const int reason = errno;
  static_cast<void>(!::write(report, &reason, sizeof reason));
  _exit(127);
}

std::string last_line(int file) {
  std::array<char, 2048> tail{};
  const off_t size = lseek(file, 0, SEEK_END);
  const off_t from = std::max<off_t>(0, size - static_cast<off_t>(tail.size()));
  const ssize_t count = pread(file, tail.data(), tail.size(), from);
  std::string_view text(tail.data(), static_cast<std::size_t>(std::max<ssize_t>(0, count)));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  if (const auto line = text.find_last_of("\n\r"); line != std::string_view::npos)
    text.remove_prefix(line + 1);
  return std::string(text);
}

void close_file(int& file) {
  if (file >= 0) close(file);
  file = -1;
}

int wait_for(pid_t process) {
  int state = 0;
  while (waitpid(process, &state, 0) < 0 && errno == EINTR) continue;
  return state;
}

}  // namespace

Result<void> program_is_there(const std::string& name, const std::string& package) {
  const char* const path = std::getenv("PATH");
  std::string_view folders = path ? path : "/usr/local/bin:/usr/bin:/bin";
  while (!folders.empty()) {
    const std::string_view folder = folders.substr(0, folders.find(':'));
    if (access((std::string(folder) + "/" + name).c_str(), X_OK) == 0) return {};
    folders.remove_prefix(std::min(folders.size(), folder.size() + 1));
  }
  return failure(name, "is not installed; install the Debian package '" + package + "'");
}

Result<ProgramPipe> ProgramPipe::start(const std::vector<std::string>& command) {
  const std::string& name = command.front();
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  // a socket, since writing to one can fail without a signal
  std::array<int, 2> ends{-1, -1}, report{-1, -1};
  int errors = memfd_create("errors", MFD_CLOEXEC);
  if (errors < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0 ||
      pipe2(report.data(), O_CLOEXEC) != 0) {
    const int reason = errno;
    for (int* file : {&errors, ends.data(), &ends[1]}) close_file(*file);
    return failure(name, std::string("cannot be started: ") + std::strerror(reason));
  }
  const pid_t parent = getpid(), child = fork();
  int reason = child < 0 ? errno : 0;
  if (child == 0) become(words.data(), ends[1], errors, report[1], parent);
  close_file(ends[1]), close_file(report[1]);
  if (child > 0) {
    int given = 0;
    ssize_t got = -1;
    do got = read(report[0], &given, sizeof given);
    while (got < 0 && errno == EINTR);
    if (got == static_cast<ssize_t>(sizeof given)) reason = given, wait_for(child);
  }
  close_file(report[0]);
  if (reason == 0) return ProgramPipe(name, child, ends[0], errors);
  close_file(ends[0]), close_file(errors);
  return failure(name, std::string("cannot be started: ") + std::strerror(reason));
}

Result<void> ProgramPipe::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return complaint();
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

Result<void> ProgramPipe::finish() {
  close_file(input_);
  const int state = wait_for(std::exchange(process_, -1));
  if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return {};
  return complaint();
}

tl::unexpected<Error> ProgramPipe::complaint() {
  close_file(input_);
  if (process_ > 0) wait_for(std::exchange(process_, -1));
  const std::string said = last_line(errors_);
  return failure(name_, "stopped early" + (said.empty() ? std::string() : ": " + said));
}

ProgramPipe::ProgramPipe(ProgramPipe&& other) noexcept
    : name_(std::move(other.name_)),
      process_(std::exchange(other.process_, -1)),
      input_(std::exchange(other.input_, -1)),
      errors_(std::exchange(other.errors_, -1)) {}

ProgramPipe::~ProgramPipe() {
  close_file(input_);
  if (process_ > 0) {
    kill(process_, SIGKILL);
    wait_for(process_);
  }
  close_file(errors_);
}

}  // namespace borelli
