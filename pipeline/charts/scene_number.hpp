// Reads and replaces any number in a scene's file by its path, for sweeps.
//
// A path joins keys by dots: `simulation.step`, `gravity[2]`, `solid[cube].shape.mass`,
// `effort[spring].stiffness`, `solid[bar 2].joint[1].value`. Brackets hold an index into a list, from 0, or
// the `name` of an element. A solid, effort or constraint with a unique name may be given by its name alone:
// `spring.stiffness`. Numbers of [simulation] may be set even if the file does not state them.
#pragma once

#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// The scene's text with `value` as the number at `path`; all else stays the same, line for line. `file`
/// names the text in errors. If there is no such number, the error names the nearest paths.
Result<std::string> with_number(std::string_view text, const std::string& file, const std::string& path,
                                double value);

/// The number at a path.
Result<double> number_at(std::string_view text, const std::string& file, const std::string& path);

}  // namespace borelli
