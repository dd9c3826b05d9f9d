// Writes a simulation's certificate as text and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "dynamics/system/certificate.hpp"

namespace borelli {

/// Lines: verdict, energy, work, momentum, constraints, steps, notes.
std::string text_of(const Certificate& certificate);

/// Every field under its own name, in SI units; non-finite numbers become null.
nlohmann::json json_of(const Certificate& certificate);

}  // namespace borelli
