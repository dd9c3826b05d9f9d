#include "process/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace borelli {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();
std::atomic<std::uint64_t> limit = 0;  // 0: not set yet
std::atomic<bool> limited_from_outside = false;

// bytes of the line `key` in a file of "key: number kB" lines; unlimited if there is none
std::uint64_t bytes_in_line(const char* path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key + ":")) continue;
    std::istringstream rest(line.substr(key.size() + 1));
    if (std::uint64_t value = 0; rest >> value) return value * 1024;
  }
  return unlimited;
}

std::uint64_t number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  return file >> value ? value : unlimited;  // "max": no limit
}

// bytes left in the control group, version 2 or 1
std::uint64_t free_in_group() {
  std::uint64_t least = unlimited;
  const auto ask = [&](const std::string& most_file, const std::string& used_file) {
    const std::uint64_t most = number_in(most_file), used = number_in(used_file);
    if (most != unlimited && used != unlimited) least = std::min(least, most > used ? most - used : 0);
  };
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const auto path = line.substr(line.rfind(':') + 1);
    if (line.starts_with("0::"))
      ask("/sys/fs/cgroup" + path + "/memory.max", "/sys/fs/cgroup" + path + "/memory.current");
    else if (line.find(":memory:") != std::string::npos)
      ask("/sys/fs/cgroup/memory" + path + "/memory.limit_in_bytes",
          "/sys/fs/cgroup/memory" + path + "/memory.usage_in_bytes");
  }
  return least;
}

// bytes that the limits of this process leave (ulimit -v, -d)
std::uint64_t free_in_process() {
  std::uint64_t least = unlimited;
  for (const auto& [resource, used] : {std::pair{RLIMIT_AS, "VmSize"}, {RLIMIT_DATA, "VmData"}}) {
    rlimit most{};
    const std::uint64_t in_use = bytes_in_line("/proc/self/status", used);
    if (getrlimit(resource, &most) != 0) continue;
    // set_memory_limit sets the soft limit of RLIMIT_DATA
    const rlim_t bytes = resource == RLIMIT_DATA ? most.rlim_max : most.rlim_cur;
    if (bytes == RLIM_INFINITY || in_use == unlimited) continue;
    least = std::min<std::uint64_t>(least, bytes > in_use ? bytes - in_use : 0);
  }
  return least;
}

// Resident memory less the heap's free blocks. Free blocks may not be resident yet, so the result is at least
// what the heap has handed out.
std::uint64_t bytes_in_use() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t mapped = 0, resident = 0;
  if (!(file >> mapped >> resident)) return 0;
  resident *= static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
#ifdef __GLIBC__
  const struct mallinfo2 heap = mallinfo2();
  return std::max<std::uint64_t>(resident - std::min<std::uint64_t>(resident, heap.fordblks),
                                 heap.uordblks + heap.hblkhd);
#else
  return resident;
#endif
}

std::string in_words(double bytes) {
  std::array<char, 32> text{};
  if (bytes < 1e9)
    std::snprintf(text.data(), text.size(), "%.3g MB", bytes / 1e6);
  else
    std::snprintf(text.data(), text.size(), "%.3g GB", bytes / 1e9);
  return text.data();
}

}  // namespace

std::uint64_t free_memory() {
  return std::min({bytes_in_line("/proc/meminfo", "MemAvailable"), free_in_group(), free_in_process()});
}

void set_memory_limit(std::uint64_t bytes) {
  const std::uint64_t free = free_in_process();
  limited_from_outside = free / 4 * 3 <= bytes;
  limit = std::max<std::uint64_t>(std::min(bytes, free), 1);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // RLIMIT_DATA counts writable mappings, which exceed memory in use: stacks, the heap's free blocks
  constexpr std::uint64_t slack = std::uint64_t{2} << 30;
  rlimit data{};
  if (getrlimit(RLIMIT_DATA, &data) == 0 && bytes < unlimited - slack) {
    data.rlim_cur = std::min<rlim_t>(data.rlim_max, bytes + slack);
    setrlimit(RLIMIT_DATA, &data);
  }
#endif
}

std::uint64_t memory_limit() {
  if (limit == 0) {
    const std::uint64_t free = free_memory();
    std::uint64_t unset = 0;
    limit.compare_exchange_strong(unset,
                                  free == unlimited ? unlimited : std::max<std::uint64_t>(free / 4 * 3, 1));
  }
  return limit;
}

std::optional<std::uint64_t> bytes_from(std::string_view text) {
  double number = 0;
  const auto [rest, trouble] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string unit(rest, text.data() + text.size());
  if (trouble != std::errc() || !(number >= 0)) return std::nullopt;
  std::erase(unit, ' ');
  for (char& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  double base = 1000;
  if (unit.ends_with("IB") && unit.size() == 3)
    base = 1024, unit.resize(1);
  else if (unit.ends_with('B'))
    unit.pop_back();
  const std::string_view prefixes = "KMGT";
  const auto power = unit.empty() ? 0 : unit.size() == 1 ? prefixes.find(unit) + 1 : 0;
  if (unit.size() > 1 || (!unit.empty() && power == 0)) return std::nullopt;
  for (std::size_t n = 0; n < power; ++n) number *= base;
  if (!(number < 9e18)) return std::nullopt;
  return static_cast<std::uint64_t>(number);
}

tl::unexpected<Error> out_of_memory(const std::string& where, const std::string& what) {
  return failure(where, what + " needs more memory than the " +
                            in_words(static_cast<double>(memory_limit())) + " that may be used; " +
                            (limited_from_outside ? "raise the limits of this process (ulimit)"
                                                  : "give a larger --max-memory"));
}

Result<void> admit_memory(const std::string& where, const std::string& what, double bytes) {
  const double most = static_cast<double>(memory_limit()), used = static_cast<double>(bytes_in_use());
  if (used + bytes <= most) return {};
  return failure(where, what + " needs " + in_words(bytes) + " of memory; " + in_words(most) +
                            " may be used (" + (limited_from_outside ? "ulimit" : "--max-memory") +
                            "), of which " + in_words(used) + " are in use");
}

}  // namespace borelli
