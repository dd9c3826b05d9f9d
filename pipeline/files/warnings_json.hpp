// Warnings in JSON, each with its kind.
//
//   {"kind": "sides", "severity": "doubt", "text": "left and right differ in volume: hands 27 %",
//    "head": "left and right differ in volume", "item": "hands 27 %"}
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "segmentation/volume/warning.hpp"

namespace borelli {

/// A list of objects as above; "head", "item" and "reason" only if not empty.
nlohmann::json to_json(const std::vector<Warning>& warnings);

/// Reads them back. Other objects are ignored. An unknown kind or severity becomes a note on the scan.
std::vector<Warning> warnings_from(const nlohmann::json& list);

/// A stage's warnings as an entry of run.json: "warnings" as sentences, "single_warnings" as above.
nlohmann::json warnings_entry(const std::vector<Warning>& warnings);

}  // namespace borelli
