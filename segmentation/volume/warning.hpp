// Warnings about a result: sentences, each with a kind and a severity.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// What a warning is about. Among warnings of equal severity, the earlier kind comes first.
enum class WarningKind {
  scan,      ///< how the file was read, and how the body lies in it
  body,      ///< the body as a whole
  part,      ///< a part's bounds or size
  sides,     ///< left and right differ
  joint,     ///< a joint's place
  landmark,  ///< landmarks that were given
  labels,    ///< labels that were given
  range,     ///< a joint angle outside its usual range
  table      ///< uncertainty of the inertia table
};
std::string_view name_of(WarningKind kind);

enum class Severity {
  note,   ///< worth knowing
  doubt,  ///< makes the result doubtful (verdict.hpp)
  fault   ///< something is certainly wrong
};
std::string_view name_of(Severity severity);

struct Warning {
  WarningKind kind = WarningKind::scan;
  Severity severity = Severity::note;
  std::string text;  ///< a complete sentence
  /// Warnings with the same head are joined into one sentence: "head: item (reason), item, item (reason)". If
  /// `head` is empty, the text is never joined with others.
  std::string head = {}, item = {}, reason = {};
};

/// A warning whose own text is "head: item (reason)".
Warning joined_warning(WarningKind kind, Severity severity, std::string head, std::string item,
                       std::string reason = "");

/// The warnings as sentences, the most severe first. Warnings with the same head are joined, with items of
/// the same reason side by side. Repeated sentences are left out.
std::vector<std::string> in_sentences(const std::vector<Warning>& warnings);

/// Adds sentences, e.g. from a reader, each as a warning of its own.
void add_warnings(std::vector<Warning>& warnings, WarningKind kind, Severity severity,
                  const std::vector<std::string>& sentences);

}  // namespace borelli
