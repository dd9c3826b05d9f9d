// A switch of a joint in a scene file: its kind, its coordinate, how that moves and where it may be.
#pragma once

#include "dynamics/switch.hpp"
#include "dynamics/toml_table.hpp"

namespace borelli {

/// Reads one switch, and finishes its table. Throws TomlRefusal.
Switch read_switch(TomlTable& table);

}  // namespace borelli
