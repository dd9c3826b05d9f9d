// Scenes as TOML files that a person reads and writes by hand: [[solid]] with its joint, inertia and shapes,
// [[effort]], [[constraint]], [simulation]. samples/README.md lists the keys, samples/*.toml show them.
//
// SI units; degrees only in keys that end in _deg. The fields of efforts, constraints and functions of time
// are those of their structs, by the same names (see effort_force.hpp and its neighbours); `kind` chooses the
// struct.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// The scene that a text states; `file` names it in errors. Unknown or missing keys, wrong types, numbers
/// that are not finite, names that are used twice or not there, parents in a circle, axes that are not unit
/// and inertias that no body can have are refused with file and line.
Result<Scene> parse_scene(std::string_view text, const std::string& file);

/// The scene in a file; besides what parse_scene refuses, a file that is no text and a scene without solids.
Result<Scene> read_scene(const std::filesystem::path& path);

/// The scene's text; parse_scene gives every number of it back exactly, in the same order. Fails on a
/// what is C++ (FunctionConstraint, OwnEffort) and has no place in a file.
Result<std::string> write_scene(const Scene& scene);

}  // namespace borelli
