// A switch of a joint in a scene file: its kind, its coordinate, how that moves and where it may be.
#pragma once

#include "dynamics/formats/toml_table.hpp"
#include "dynamics/scene/switch.hpp"

namespace borelli {

/// One table of a joint, read to its end: one switch, or those that a short form (universal, cylindrical,
/// planar, free) stands for.
std::vector<Switch> read_switches(TomlTable& table);

}  // namespace borelli
