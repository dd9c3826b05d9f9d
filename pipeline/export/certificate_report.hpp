// A simulation's certificate for people and for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "dynamics/system/certificate.hpp"

namespace borelli {

/// Lines: verdict, energy, work, momentum, constraints, steps, notes.
std::string text_of(const Certificate& certificate);

/// Every field under its own name, SI units; numbers that are not finite become null.
nlohmann::json json_of(const Certificate& certificate);

}  // namespace borelli
