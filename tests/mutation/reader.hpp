// What reads files that may be damaged, as a function of a file: the table that mutation tests and fuzz
// targets go through.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "tests/mutation/test_case.hpp"

namespace borelli::mutation {

struct Reader {
  std::string_view name;
  /// Valid inputs, small ones of each kind.
  std::vector<TestCase> (*seeds)();
  /// Reads `file`, which lies in its folder with the files it names, and does with it what a verb would do
  /// first: a volume has as many voxels as its grid, a scene is compiled, evaluated and moved by a few steps.
  /// Errors: what the program would tell the user; `defect()` where what was read is not sane.
  Result<void> (*read)(const std::filesystem::path& file);
  bool may_print = false;  ///< it is a verb, which says things beside its answer
};

/// Of readers.def, in its order.
const std::vector<Reader>& readers();
/// Null where there is none.
const Reader* find_reader(std::string_view name);

/// An answer that is wrong in itself, whatever was in the file. Errors that begin so are failures.
tl::unexpected<Error> defect(const std::string& what);
inline constexpr std::string_view defect_place = "DEFECT";

/// What is wrong with an error as words for the user: a library's own text, no sentence, no file named.
/// Empty: nothing. `file`: the one that was read.
std::string fault_in(const Error& error, const std::filesystem::path& file);

/// Reads and judges; what a library throws is caught and named. Empty: all is well. `refused`: the reader
/// answered an error.
std::string fault_in_reading(const Reader& reader, const std::filesystem::path& file, bool& refused,
                             std::string& said);

/// The program's verb with these words, as --json answers it. Where the whole program is not there (in the
/// fuzz target) nothing is done.
Result<void> run_verb(const std::vector<std::string>& words);

#define BORELLI_READER(name) Reader name##_reader();
#define BORELLI_PROGRAM_READER(name) Reader name##_reader();
#include "tests/mutation/readers.def"
#undef BORELLI_READER
#undef BORELLI_PROGRAM_READER

}  // namespace borelli::mutation
