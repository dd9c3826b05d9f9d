#include "process/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <utility>

namespace borelli {
namespace {

// exit codes of a child that no signal ended
constexpr int done = 0, failed = 1, out_of_memory = 2;

// Sanitizers map terabytes of shadow memory: a limit on mappings would end the child at once.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool may_limit_mappings = false;
#else
constexpr bool may_limit_mappings = true;
#endif

std::uint64_t mapped_bytes() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return std::uint64_t{pages} * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// Address space for the stacks of one thread per processor: the JPEG 2000 codec starts that many.
std::uint64_t bytes_of_stacks() {
  std::size_t stack = std::size_t{8} << 20, guard = 0;
#ifdef __GLIBC__
  pthread_attr_t usual;
  if (pthread_getattr_default_np(&usual) == 0) {
    pthread_attr_getstacksize(&usual, &stack);
    pthread_attr_getguardsize(&usual, &guard);
    pthread_attr_destroy(&usual);
  }
#endif
  const long processors = std::max(sysconf(_SC_NPROCESSORS_CONF), 1L);
  return static_cast<std::uint64_t>(processors) * (stack + guard);
}

void write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(file, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

// Runs in the child and ends it. An error goes to `pipe` as its kind ('u' or 'f'), place, a zero byte, words.
[[noreturn]] void be_child(int pipe, pid_t parent, const ChildLimits& limits,
                           const std::function<Result<void>()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(failed);  // the parent ended before prctl
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPROF})
    std::signal(signal, SIG_DFL);
  const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nowhere, STDOUT_FILENO), dup2(nowhere, STDERR_FILENO);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if (may_limit_mappings) {
#ifdef __GLIBC__
    mallopt(M_ARENA_MAX, 1);  // a heap for each thread would reserve 128 MiB each
#endif
    const rlimit mappings{mapped_bytes() + bytes_of_stacks() + limits.bytes, RLIM_INFINITY};
    setrlimit(RLIMIT_AS, &mappings);
  }
  if (limits.processor_seconds > 0) {  // SIGPROF ends the child; other processes' time does not count
    const double whole = std::floor(limits.processor_seconds);
    const itimerval time{
        {0, 0},
        {static_cast<time_t>(whole), static_cast<suseconds_t>(1e6 * (limits.processor_seconds - whole)) + 1}};
    setitimer(ITIMER_PROF, &time, nullptr);
  }
  int code = failed;
  try {
    const Result<void> answer = work();
    code = answer ? done : failed;
    if (!answer)
      write_all(pipe, (answer.error().kind == Error::Kind::use ? "u" : "f") + answer.error().where + '\0' +
                          answer.error().what);
  } catch (const std::bad_alloc&) {
    code = out_of_memory;
  } catch (...) {  // from a library: its text does not help a user
  }
  _exit(code);
}

// Reads what the child writes until it ends. Returns false if its time ran out first.
bool read_until_end(int pipe, double seconds, std::string& text) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0) return false;
    pollfd ready{pipe, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(std::min<long long>(left + 1, 1000)));
    if (count <= 0) continue;
    std::array<char, 4096> block;
    const ssize_t got = read(pipe, block.data(), block.size());
    if (got == 0) return true;
    if (got > 0) text.append(block.data(), static_cast<std::size_t>(got));
  }
}

const char* signal_words(int signal) {
  switch (signal) {
    case SIGSEGV:
    case SIGBUS:
      return "segmentation fault";
    case SIGFPE:
      return "division by zero";
    case SIGABRT:
      return "abort";
    default:
      return "ended by a signal";
  }
}

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

}  // namespace

Result<void> in_child(const std::string& where, const std::string& doing, const ChildLimits& limits,
                      const std::function<Result<void>()>& work) {
  // A child forked by another thread meanwhile would inherit the pipe's write end and keep it open. This
  // thread would then wait for that child too.
  static std::mutex one_at_a_time;
  std::unique_lock lock(one_at_a_time);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    return failure(where, doing + " needs a pipe, which cannot be created: " + std::strerror(errno));
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) {
    const std::string reason = std::strerror(errno);
    close(ends[0]), close(ends[1]);
    return failure(where, doing + " needs its own process, which cannot be started: " + reason);
  }
  if (child == 0) be_child(ends[1], parent, limits, work);
  close(ends[1]);
  lock.unlock();
  std::string text;
  const bool ended = read_until_end(ends[0], limits.seconds, text);
  close(ends[0]);
  if (!ended) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!ended) return failure(where, doing + " took more than " + number(limits.seconds) + " s");
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF)
    return failure(where, doing + " took more than " + number(limits.processor_seconds) + " s");
  if (WIFSIGNALED(status)) return failure(where, doing + " crashed (" + signal_words(WTERMSIG(status)) + ")");
  if (WEXITSTATUS(status) == done) return {};
  if (WEXITSTATUS(status) == out_of_memory)
    return failure(where,
                   doing + " took more than " + number(double(limits.bytes) / (1 << 20)) + " MiB of memory");
  const auto zero = text.find('\0');
  if (zero == std::string::npos) return failure(where, doing + " failed");
  const std::string place = text.substr(1, zero - 1), what = text.substr(zero + 1);
  return text.front() == 'u' ? bad_use(place, what) : failure(place, what);
}

Result<SharedBytes> SharedBytes::make(const std::string& where, std::size_t size) {
  void* const start = mmap(nullptr, std::max<std::size_t>(size, 1), PROT_READ | PROT_WRITE,
                           MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (start == MAP_FAILED) return failure(where, "does not fit into memory");
  return SharedBytes(static_cast<std::byte*>(start), size);
}

SharedBytes::SharedBytes(SharedBytes&& other) noexcept
    : start_(std::exchange(other.start_, nullptr)), size_(std::exchange(other.size_, 0)) {}

SharedBytes::~SharedBytes() {
  if (start_) munmap(start_, std::max<std::size_t>(size_, 1));
}

}  // namespace borelli
