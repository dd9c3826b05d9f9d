// What is worth knowing of a result, or makes it doubtful: sentences, each with its kind and how grave it is.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// What a warning is about; of two that are equally grave the earlier kind comes first.
enum class WarningKind {
  scan,      ///< how the file was read, and how the body lies in it
  body,      ///< the body as a whole
  part,      ///< a part's bounds or size
  sides,     ///< left and right differ
  joint,     ///< a joint's place
  landmark,  ///< landmarks that were given
  labels,    ///< labels that were given
  range,     ///< a joint angle outside its usual range
  table      ///< how sure the inertia table is
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
  std::string text;  ///< a whole sentence, which stands alone
  /// Several with one head are said in one sentence: "head: item (reason), item, item (reason)". Where it is
  /// empty the text is never joined with others.
  std::string head = {}, item = {}, reason = {};
};

/// A warning whose own text is "head: item (reason)".
Warning joined_warning(WarningKind kind, Severity severity, std::string head, std::string item,
                       std::string reason = "");

/// The warnings in sentences, the gravest first; those of one head are joined, and items of one reason stand
/// together. Repeated sentences are left out.
std::vector<std::string> in_sentences(const std::vector<Warning>& warnings);

/// Adds sentences that somebody else wrote, each as a warning of its own.
void add_warnings(std::vector<Warning>& warnings, WarningKind kind, Severity severity,
                  const std::vector<std::string>& sentences);

}  // namespace borelli
