// Any number in a scene's file by its path, so that a sweep can change it.
//
// A path goes from key to key by dots: `simulation.step`, `gravity[2]`, `solid[cube].shape.mass`,
// `effort[spring].stiffness`, `solid[bar 2].joint[1].value`. In brackets stands the place in a list, from 0,
// or the `name` of what stands there; a solid, effort or constraint may go by its name alone where no other
// has it: `spring.stiffness`. Numbers of [simulation] that a file does not state may be set all the same.
#pragma once

#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// The scene's text with `value` for the number at `path`, all else as it was, line for line. `file` names it
/// in errors. Where there is no such number the error names those that come nearest.
Result<std::string> with_number(std::string_view text, const std::string& file, const std::string& path,
                                double value);

/// The number at a path.
Result<double> number_at(std::string_view text, const std::string& file, const std::string& path);

}  // namespace borelli
