// A switch of a joint in a scene file: its kind, coordinate, motion and ranges.
#pragma once

#include "dynamics/formats/toml_table.hpp"
#include "dynamics/scene/switch.hpp"

namespace borelli {

/// Reads one table of a joint and finishes it: one switch, or the switches of a short form (universal,
/// cylindrical, planar, free).
std::vector<Switch> read_switches(TomlTable& table);

}  // namespace borelli
