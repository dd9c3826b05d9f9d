// Warnings in JSON, each with its kind.
//
//   {"kind": "sides", "severity": "doubt", "text": "left and right differ in volume: hands 27 %",
//    "head": "left and right differ in volume", "item": "hands 27 %"}
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "segmentation/volume/warning.hpp"

namespace borelli {

/// A list of objects as above; "head", "item" and "reason" where they are not empty.
nlohmann::json to_json(const std::vector<Warning>& warnings);

/// The same back. What is no such object is left out; a kind or severity that is not known counts as a note
/// of the scan.
std::vector<Warning> warnings_from(const nlohmann::json& list);

/// What a stage's entry in run.json says of its warnings: "warnings" in sentences, "single_warnings" as
/// above.
nlohmann::json warnings_entry(const std::vector<Warning>& warnings);

}  // namespace borelli
