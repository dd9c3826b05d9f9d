// Inertia tables as files: CSV for people and spreadsheets, JSON for programs and later stages.
//
// Both state their units. The CSV opens with comments on the table's origin. Its percentages and published
// columns, like the JSON's "derived" numbers, follow from the other numbers and are not read back.
#pragma once

#include <filesystem>
#include <string>

#include "error/error.hpp"
#include "inertia/table.hpp"

namespace borelli {

/// One row per part and one for the body; fields that are unknown or do not compare are empty or say so.
std::string to_csv(const InertiaTable& table);

/// Pretty-printed.
std::string to_json(const InertiaTable& table);

/// `where` names the text in errors. Errors: not JSON, another format, a field that is missing or of the
/// wrong type (named with its part), non-finite numbers. Flaws are determined again.
Result<InertiaTable> table_from_json(const std::string& text, const std::string& where);

/// Writes to `path`, as CSV or JSON by its extension. Errors: another extension, not writable, disk full.
Result<void> write_table(const std::filesystem::path& path, const InertiaTable& table);

/// Reads the JSON file. Errors: no such file, and as table_from_json.
Result<InertiaTable> read_table(const std::filesystem::path& path);

}  // namespace borelli
