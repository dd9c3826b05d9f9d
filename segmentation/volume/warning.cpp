#include "segmentation/volume/warning.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace borelli {
namespace {

std::string listed(const std::vector<std::string>& items) {
  std::string out;
  for (const std::string& item : items) out += (out.empty() ? "" : ", ") + item;
  return out;
}

// "head: item, item (reason), item"
std::string joined(const std::vector<const Warning*>& alike) {
  if (alike.size() == 1) return alike.front()->text;
  std::vector<std::pair<std::string, std::vector<std::string>>> by_reason;
  for (const Warning* warning : alike) {
    const auto same = std::ranges::find(by_reason, warning->reason,
                                        &std::pair<std::string, std::vector<std::string>>::first);
    auto& items =
        same == by_reason.end() ? by_reason.emplace_back(warning->reason, std::vector<std::string>{}) : *same;
    if (std::ranges::find(items.second, warning->item) == items.second.end())
      items.second.push_back(warning->item);
  }
  std::vector<std::string> groups;
  for (const auto& [reason, items] : by_reason)
    groups.push_back(listed(items) + (reason.empty() ? "" : " (" + reason + ")"));
  return alike.front()->head + ": " + listed(groups);
}

}  // namespace

std::string_view name_of(WarningKind kind) {
  switch (kind) {
    case WarningKind::scan:
      return "scan";
    case WarningKind::body:
      return "body";
    case WarningKind::part:
      return "part";
    case WarningKind::sides:
      return "sides";
    case WarningKind::joint:
      return "joint";
    case WarningKind::landmark:
      return "landmark";
    case WarningKind::labels:
      return "labels";
    case WarningKind::range:
      return "range";
    case WarningKind::table:
      return "table";
  }
  return "";
}

std::string_view name_of(Severity severity) {
  switch (severity) {
    case Severity::note:
      return "note";
    case Severity::doubt:
      return "doubt";
    case Severity::fault:
      return "fault";
  }
  return "";
}

Warning joined_warning(WarningKind kind, Severity severity, std::string head, std::string item,
                       std::string reason) {
  std::string text = head + ": " + item + (reason.empty() ? "" : " (" + reason + ")");
  return {kind, severity, std::move(text), std::move(head), std::move(item), std::move(reason)};
}

std::vector<std::string> in_sentences(const std::vector<Warning>& warnings) {
  std::vector<const Warning*> order;
  for (const Warning& warning : warnings) order.push_back(&warning);
  std::ranges::stable_sort(order, [](const Warning* a, const Warning* b) {
    return std::tuple(b->severity, a->kind) < std::tuple(a->severity, b->kind);
  });
  std::vector<std::string> sentences;
  std::vector<std::vector<const Warning*>> groups;
  for (const Warning* warning : order) {
    const auto same = std::ranges::find_if(groups, [&](const auto& group) {
      return !warning->head.empty() && group.front()->head == warning->head &&
             group.front()->kind == warning->kind;
    });
    if (same == groups.end())
      groups.push_back({warning});
    else
      same->push_back(warning);
  }
  for (const auto& group : groups)
    if (std::string sentence = joined(group);
        !sentence.empty() && std::ranges::find(sentences, sentence) == sentences.end())
      sentences.push_back(std::move(sentence));
  return sentences;
}

void add_warnings(std::vector<Warning>& warnings, WarningKind kind, Severity severity,
                  const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences)
    if (!sentence.empty()) warnings.push_back({kind, severity, sentence});
}

}  // namespace borelli
