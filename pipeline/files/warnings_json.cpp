#include "pipeline/files/warnings_json.hpp"

namespace borelli {

using nlohmann::json;

namespace {

constexpr WarningKind kinds[] = {WarningKind::scan,   WarningKind::body,  WarningKind::part,
                                 WarningKind::sides,  WarningKind::joint, WarningKind::landmark,
                                 WarningKind::labels, WarningKind::range, WarningKind::table};
constexpr Severity severities[] = {Severity::note, Severity::doubt, Severity::fault};

std::string text_of(const json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

}  // namespace

json to_json(const std::vector<Warning>& warnings) {
  json list = json::array();
  for (const Warning& warning : warnings) {
    json one{
        {"kind", name_of(warning.kind)}, {"severity", name_of(warning.severity)}, {"text", warning.text}};
    for (const auto& [key, text] :
         {std::pair{"head", &warning.head}, {"item", &warning.item}, {"reason", &warning.reason}})
      if (!text->empty()) one[key] = *text;
    list.push_back(std::move(one));
  }
  return list;
}

std::vector<Warning> warnings_from(const json& list) {
  std::vector<Warning> warnings;
  if (!list.is_array()) return warnings;
  for (const json& one : list) {
    if (!one.is_object() || text_of(one, "text").empty()) continue;
    Warning warning;
    warning.text = text_of(one, "text");
    for (const WarningKind kind : kinds)
      if (text_of(one, "kind") == name_of(kind)) warning.kind = kind;
    for (const Severity severity : severities)
      if (text_of(one, "severity") == name_of(severity)) warning.severity = severity;
    warning.head = text_of(one, "head"), warning.item = text_of(one, "item");
    warning.reason = text_of(one, "reason");
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

json warnings_entry(const std::vector<Warning>& warnings) {
  return {{"warnings", in_sentences(warnings)}, {"single_warnings", to_json(warnings)}};
}

}  // namespace borelli
