// Mutation tests of the file readers: see README.md.
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "process/memory.hpp"
#include "tests/mutation/mutate.hpp"
#include "tests/mutation/reader.hpp"
#include "tests/mutation/trial.hpp"
#include "tests/paths.hpp"
#include "threads/slabs.hpp"

namespace borelli::mutation {
namespace {

namespace fs = std::filesystem;

constexpr const char* usage =
    "usage: mutation READER|all [--runs N] [--seconds S] [--campaign C] [--first N] [--failures FOLDER]\n"
    "       mutation READER --case FILE|FOLDER       reads one case in this process\n"
    "       mutation READER --seeds FOLDER           writes the seeds for libFuzzer\n"
    "       mutation --list\n"
    "FOLDER of --failures: where failing cases go; default: borelli-mutation in the folder for temporary "
    "files\n";

struct Options {
  std::string reader, one_case, seeds;
  std::uint64_t runs = 2000, first = 0, campaign = 1;
  double seconds = 1e8;
  fs::path failures = fs::temp_directory_path() / "borelli-mutation";
};

// A scratch folder, in memory if possible, removed with the object.
class Scratch {
 public:
  Scratch() {
    std::error_code ignored;
    const fs::path memory = "/dev/shm";
    const fs::path under = access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path(ignored);
    std::string name = (under / "borelli-mutation-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no scratch folder in " + under.string());
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

// Inputs that once crashed this reader: the files of corpus/READER, and some of shared/cases.
std::vector<TestCase> corpus_of(const Reader& reader) {
  static const std::map<std::string_view, std::vector<const char*>> shared_cases{
      {"dicom", {"rle_sigfpe"}},
      {"labels", {"seg_bomb.dcm"}},
      {"landmarks", {"overflow_state.json"}},
      {"state", {"overflow_state.json"}},
      {"trajectory", {"hang.h5"}},
      {"mjcf", {"slide_over_plane.xml", "include_bomb", "hinge_and_ball.xml"}},
      {"scene", {"bricard.toml", "stack_1_to_100.toml"}}};
  std::vector<fs::path> paths;
  const fs::path own = fs::path(test::source_folder()) / "tests/mutation/corpus" / reader.name;
  if (fs::is_directory(own))
    for (const auto& entry : fs::directory_iterator(own)) paths.push_back(entry.path());
  std::ranges::sort(paths);
  if (const auto found = shared_cases.find(reader.name); found != shared_cases.end())
    for (const char* name : found->second)
      if (const fs::path path = fs::path(test::shared_folder()) / "cases" / name; fs::exists(path))
        paths.push_back(path);
  std::vector<TestCase> out;
  for (const fs::path& path : paths) out.push_back(read_case(path));
  return out;
}

// The message with each number as 0: failures that differ in numbers only are one kind.
std::string kind_of(const std::string& what) {
  std::string kind;
  for (const char c : what.substr(0, 160)) {
    const char plain = c >= '0' && c <= '9' ? '0' : c;
    if (plain != '0' || kind.empty() || kind.back() != '0') kind += plain;
  }
  return kind;
}

void print_failures(const Reader& reader, const std::vector<Failure>& failures,
                    const std::function<TestCase(std::uint64_t)>& case_of, const Options& options) {
  std::map<std::string, int> kinds;
  for (const Failure& failure : failures) {
    if (++kinds[kind_of(failure.what)] > 2) continue;
    TestCase test = case_of(failure.number);
    const fs::path folder =
        options.failures / fmt::format("{}-{}-{}", reader.name, options.campaign, test.name);
    write_case(test, folder);
    fmt::print("  {}\n    reproduce: mutation {} --case {}\n", failure.what, reader.name,
               fs::absolute(folder).string());
  }
  for (const auto& [kind, count] : kinds)
    if (count > 2) fmt::print("  {} times: {}\n", count, kind);
}

// Reads seeds and corpus as they are, then mutations of both. True: no failure.
bool run(const Reader& reader, const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  const Scratch scratch;
  const std::vector<TestCase> seeds = reader.seeds(), corpus = corpus_of(reader);
  std::vector<TestCase> all = seeds;
  all.insert(all.end(), corpus.begin(), corpus.end());
  if (seeds.empty()) throw std::runtime_error(fmt::format("{} has no seeds", reader.name));
  const TrialLimits limits;
  const fs::path folder = scratch / fmt::format("case_of_{}", reader.name);

  const auto as_it_is = [&](std::uint64_t n) { return all[n]; };
  const Trials whole = run_trials(reader, as_it_is, 0, all.size(), options.seconds, limits, folder);
  const auto mutation = [&](std::uint64_t n) { return mutated(all, reader.name, options.campaign, n); };
  const Trials trials = run_trials(reader, mutation, options.first, options.first + options.runs,
                                   options.seconds, limits, folder);

  // a refused seed tests nothing
  std::vector<Failure> failures = whole.failures;
  for (std::uint64_t n = 0; n < seeds.size(); ++n) {
    const Trials one = run_trials(reader, as_it_is, n, n + 1, 1e8, limits, folder);
    if (one.refused > 0 && !seeds[n].may_be_refused)
      failures.push_back({n, "the seed " + seeds[n].name + " is refused: " + one.last_refusal});
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print(
      "{}: {} mutations of {} seeds and {} crashers in {:.1f} s ({:.0f} a second): {} read, {} refused, "
      "{} failed\n",
      reader.name, trials.runs, seeds.size(), corpus.size(), seconds, double(trials.runs) / seconds,
      trials.runs - trials.refused, trials.refused, trials.failures.size() + failures.size());
  print_failures(reader, failures, as_it_is, options);
  print_failures(reader, trials.failures, mutation, options);
  std::fflush(stdout);
  return trials.failures.empty() && failures.empty();
}

int run_case(const Reader& reader, const fs::path& path) {
  const Scratch scratch;
  const fs::path folder = scratch / fmt::format("case_of_{}", reader.name);
  TestCase test = read_case(path);
  if (test.files.size() == 1 && test.files[0].bytes.starts_with("==> ")) test = parted(test.files[0].bytes);
  write_case(test, folder);
  bool refused = false;
  std::string said;
  const std::string fault = fault_in_reading(reader, folder / test.files.front().name, refused, said);
  fmt::print("{}\n", !fault.empty() ? fault : refused ? "refused: " + said : "read");
  return fault.empty() ? 0 : 1;
}

void write_seeds(const Reader& reader, const fs::path& folder) {
  fs::create_directories(folder);
  std::vector<TestCase> all = reader.seeds();
  for (const TestCase& crasher : corpus_of(reader)) all.push_back(crasher);
  for (const TestCase& test : all) std::ofstream(folder / test.name, std::ios::binary) << joined(test);
}

int run_words(std::vector<std::string> words) {
  if (words == std::vector<std::string>{"--list"}) {
    for (const Reader& reader : readers()) fmt::print("{}\n", reader.name);
    return 0;
  }
  Options options;
  if (words.empty() || words.size() % 2 == 0) return fmt::print(stderr, "{}", usage), 2;
  options.reader = words[0];
  for (std::size_t n = 1; n + 1 < words.size(); n += 2) {
    const std::string &name = words[n], &value = words[n + 1];
    if (name == "--runs")
      options.runs = std::stoull(value);
    else if (name == "--seconds")
      options.seconds = std::stod(value);
    else if (name == "--campaign")
      options.campaign = std::stoull(value);
    else if (name == "--first")
      options.first = std::stoull(value);
    else if (name == "--failures")
      options.failures = value;
    else if (name == "--case")
      options.one_case = value;
    else if (name == "--seeds")
      options.seeds = value;
    else
      return fmt::print(stderr, "{}", usage), 2;
  }
  if (options.reader != "all" && !find_reader(options.reader))
    return fmt::print(stderr, "{}: no such reader (mutation --list)\n", options.reader), 2;
  bool fine = true;
  for (const Reader& reader : readers()) {
    if (options.reader != "all" && options.reader != reader.name) continue;
    if (!options.one_case.empty()) return run_case(reader, options.one_case);
    if (!options.seeds.empty())
      write_seeds(reader,
                  options.reader == "all" ? fs::path(options.seeds) / reader.name : fs::path(options.seeds));
    else
      fine = run(reader, options) && fine;
  }
  return fine ? 0 : 1;
}

}  // namespace
}  // namespace borelli::mutation

int main(int argc, char** argv) {
  borelli::all_threads = 1;  // a fork copies no other thread
  borelli::set_memory_limit(std::uint64_t{1} << 30);
  try {
    return borelli::mutation::run_words({argv + 1, argv + argc});
  } catch (const std::exception& e) {
    fmt::print(stderr, "mutation: {}\n", e.what());
    return 2;
  }
}
