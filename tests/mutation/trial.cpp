#include "tests/mutation/trial.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <stdexcept>

namespace borelli::mutation {
namespace {

constexpr std::uint64_t readings_of_worker = 500;  // then a fresh worker: bounds leaks

// shared memory of the worker and the program
struct Board {
  std::atomic<std::uint64_t> number;           // the case that is being read
  std::atomic<std::int64_t> clock, processor;  // ns, when its reading began
  std::atomic<std::uint64_t> runs, refused;
  std::array<char, 300> refusal;  // the last one's words
};

std::int64_t nanoseconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::uint64_t mapped_bytes() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return std::uint64_t{pages} * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit_memory([[maybe_unused]] std::uint64_t bytes) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they map shadow memory
  rlimit mappings{};
  getrlimit(RLIMIT_AS, &mappings);
  mappings.rlim_cur = mapped_bytes() + bytes;
  setrlimit(RLIMIT_AS, &mappings);
#endif
}

// Takes what standard output and error got since the last call.
std::string printed(int file) {
  struct stat status {};
  std::fflush(stdout);
  if (fstat(file, &status) != 0 || status.st_size == 0) return "";
  std::array<char, 300> text{};
  const auto got = pread(file, text.data(), text.size() - 1, 0);
  if (ftruncate(file, 0) != 0 || lseek(file, 0, SEEK_SET) != 0) return "output that cannot be taken away";
  return std::string(text.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
}

void tell(int pipe, std::uint64_t number, const std::string& what) {
  // one write of less than PIPE_BUF is atomic
  std::string line = std::to_string(number) + " " + what.substr(0, 1500);
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  line += '\n';
  static_cast<void>(write(pipe, line.data(), line.size()) + 0);
}

[[noreturn]] void work(const Reader& reader, const std::function<TestCase(std::uint64_t)>& case_of,
                       std::uint64_t first, std::uint64_t last, const TrialLimits& limits,
                       const std::filesystem::path& folder, Board& board, int pipe) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const int output = memfd_create("output", MFD_CLOEXEC);
  dup2(output, STDOUT_FILENO), dup2(output, STDERR_FILENO);
  limit_memory(limits.bytes);
  for (std::uint64_t number = first; number < last; ++number) {
    board.clock = nanoseconds(CLOCK_MONOTONIC);
    board.processor = nanoseconds(CLOCK_PROCESS_CPUTIME_ID);
    board.number = number;
    const TestCase test = case_of(number);
    write_case(test, folder);
    bool refused = false;
    std::string said;
    std::string fault = fault_in_reading(reader, folder / test.files.front().name, refused, said);
    if (const std::string text = printed(output); fault.empty() && !text.empty() && !reader.may_print)
      fault = "it printed: " + text;
    if (refused) {
      ++board.refused;
      std::snprintf(board.refusal.data(), board.refusal.size(), "%s", said.c_str());
    }
    ++board.runs;
    if (!fault.empty()) tell(pipe, number, fault);
  }
  _exit(0);
}

class SharedBoard {
 public:
  SharedBoard()
      : board_(static_cast<Board*>(
            mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    if (board_ == MAP_FAILED) throw std::runtime_error("no memory to share with a child");
  }
  ~SharedBoard() { munmap(board_, sizeof(Board)); }
  SharedBoard(const SharedBoard&) = delete;
  SharedBoard& operator=(const SharedBoard&) = delete;
  Board& operator*() { return *board_; }
  Board* operator->() { return board_; }

 private:
  Board* board_;
};

std::string overdue(Board& board, pid_t worker, const TrialLimits& limits) {
  const double clock = 1e-9 * double(nanoseconds(CLOCK_MONOTONIC) - board.clock);
  clockid_t of_worker{};
  double processor = 0;
  if (clock_getcpuclockid(worker, &of_worker) == 0)
    processor = 1e-9 * double(nanoseconds(of_worker) - board.processor);
  if (processor > limits.seconds || clock > 3 * limits.seconds)
    return "a hang: more than " + std::to_string(static_cast<int>(limits.seconds)) + " s";
  return "";
}

// Moves the complete lines of `text` to `failures`.
void take_lines(std::string& text, std::vector<Failure>& failures) {
  for (auto end = text.find('\n'); end != text.npos; end = text.find('\n')) {
    const auto blank = text.find(' ');
    failures.push_back({std::stoull(text.substr(0, blank)), text.substr(blank + 1, end - blank - 1)});
    text.erase(0, end + 1);
  }
}

}  // namespace

Trials run_trials(const Reader& reader, const std::function<TestCase(std::uint64_t)>& case_of,
                  std::uint64_t first, std::uint64_t last, double seconds, const TrialLimits& limits,
                  const std::filesystem::path& folder) {
  Trials trials;
  SharedBoard board;
  const std::int64_t end =
      nanoseconds(CLOCK_MONOTONIC) + static_cast<std::int64_t>(std::min(seconds, 1e8) * 1e9);
  std::uint64_t next = first;
  while (next < last && nanoseconds(CLOCK_MONOTONIC) < end) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    const std::uint64_t stop = std::min(last, next + readings_of_worker);
    board->number = next;
    board->clock = nanoseconds(CLOCK_MONOTONIC);
    board->processor = 0;
    const pid_t worker = fork();
    if (worker < 0) throw std::runtime_error("no process");
    if (worker == 0) work(reader, case_of, next, stop, limits, folder, *board, ends[1]);
    close(ends[1]);
    std::string text, late;
    for (bool open = true; open;) {
      pollfd ready{ends[0], POLLIN, 0};
      if (poll(&ready, 1, 200) > 0) {
        std::array<char, 4096> block{};
        const auto got = read(ends[0], block.data(), block.size());
        if (got > 0) text.append(block.data(), static_cast<std::size_t>(got));
        open = got > 0 || (got < 0 && errno == EINTR);
      } else if (late = overdue(*board, worker, limits); !late.empty()) {
        kill(worker, SIGKILL);
        open = false;
      }
    }
    close(ends[0]);
    int status = 0;
    while (waitpid(worker, &status, 0) < 0 && errno == EINTR) {
    }
    take_lines(text, trials.failures);
    next = stop;
    if (late.empty() && WIFSIGNALED(status))
      late = std::string("a crash: ") + strsignal(WTERMSIG(status));
    else if (late.empty() && WEXITSTATUS(status) != 0)
      late = "it ended the program with code " + std::to_string(WEXITSTATUS(status));
    if (late.empty()) continue;
    trials.failures.push_back({board->number, late});
    next = board->number + 1;
    ++board->runs;
  }
  trials.runs = board->runs;
  trials.refused = board->refused;
  trials.last_refusal = board->refusal.data();
  return trials;
}

}  // namespace borelli::mutation
