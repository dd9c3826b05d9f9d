// libFuzzer target of the readers: fuzz --reader=NAME CORPUS ... An input is a test case as joined() writes
// it; `mutation NAME --seeds FOLDER` writes seeds.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "process/memory.hpp"
#include "tests/mutation/reader.hpp"
#include "threads/slabs.hpp"

namespace {

const borelli::mutation::Reader* reader = nullptr;
std::filesystem::path folder;

void remove_folder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (int n = 1; n < *argc; ++n)
    if (const std::string word = (*argv)[n]; word.starts_with("--reader="))
      reader = borelli::mutation::find_reader(word.substr(9));
  if (!reader) {
    std::fprintf(stderr, "fuzz: give a reader, --reader=NAME:");
    for (const auto& known : borelli::mutation::readers())
      std::fprintf(stderr, " %s", std::string(known.name).c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  borelli::all_threads = 1;
  borelli::set_memory_limit(std::uint64_t{1} << 30);
  const bool memory = access("/dev/shm", W_OK) == 0;
  folder = std::filesystem::path(memory ? "/dev/shm" : std::filesystem::temp_directory_path()) /
           ("borelli-fuzz-" + std::to_string(getpid()));
  std::atexit(remove_folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace borelli::mutation;
  const TestCase test = parted({reinterpret_cast<const char*>(data), size});
  write_case(test, folder);
  bool refused = false;
  std::string said;
  const std::string fault = fault_in_reading(*reader, folder / test.files.front().name, refused, said);
  if (fault.empty()) return 0;
  std::fprintf(stderr, "fault: %s\n", fault.c_str());
  std::abort();
}
