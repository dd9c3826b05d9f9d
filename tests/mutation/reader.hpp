// The file readers, as a table for the mutation tests and the fuzz target.
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
  /// Small valid inputs of each kind.
  std::vector<TestCase> (*seeds)();
  /// Reads `file`, whose folder holds the files it names, and does what a verb would do first: check a
  /// volume's voxel count, or compile and evaluate a scene and take a few steps. Errors: those that the
  /// program would tell the user; `defect()` if the values read are not sane.
  Result<void> (*read)(const std::filesystem::path& file);
  bool may_print = false;  ///< a verb, which may also print
};

/// All readers, in the order of readers.def.
const std::vector<Reader>& readers();
/// Null if there is no such reader.
const Reader* find_reader(std::string_view name);

/// A result that is wrong whatever the file holds. Errors at `defect_place` are failures of the test.
tl::unexpected<Error> defect(const std::string& what);
inline constexpr std::string_view defect_place = "DEFECT";

/// Why an error is unfit for users: a library's text, no sentence, or no file name; empty if it is fit.
/// `file` was read.
std::string fault_in(const Error& error, const std::filesystem::path& file);

/// Reads a file and judges the answer; exceptions are caught and named. Empty: no fault. `refused`: the
/// reader returned an error, whose message is `said`.
std::string fault_in_reading(const Reader& reader, const std::filesystem::path& file, bool& refused,
                             std::string& said);

/// Runs a verb with these arguments and --json, as the program does; gives the verb's error.
Result<void> run_verb(const std::vector<std::string>& words);

#define BORELLI_READER(name) Reader name##_reader();
#include "tests/mutation/readers.def"
#undef BORELLI_READER

}  // namespace borelli::mutation
