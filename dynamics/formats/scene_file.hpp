// Scenes as TOML files, read and written by hand: [[solid]] with its joint, inertia and shapes, [[effort]],
// [[constraint]], [simulation]. samples/README.md lists the keys, samples/*.toml show them.
//
// SI units; degrees only in keys that end in _deg. Fields of efforts, constraints and functions of time have
// the names of the fields of their structs (see effort_force.hpp and its neighbours); `kind` selects the
// struct.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// Parses a scene; `file` names it in errors. Refuses, with file and line: unknown or missing keys, wrong
/// types, numbers that are not finite, duplicate or unknown names, cycles of parents, axes that are not unit,
/// and impossible inertias.
Result<Scene> parse_scene(std::string_view text, const std::string& file);

/// Reads a scene from a file. Refuses also files that are not text and scenes without solids.
Result<Scene> read_scene(const std::filesystem::path& path);

/// The text of a scene; parse_scene restores every number exactly, in the same order. Fails on user C++
/// (FunctionConstraint, OwnEffort), which a file cannot hold.
Result<std::string> write_scene(const Scene& scene);

}  // namespace borelli
