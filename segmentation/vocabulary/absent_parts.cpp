#include "segmentation/vocabulary/absent_parts.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace borelli {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

Result<AbsentParts> parse_absent(std::string_view text) {
  AbsentParts absent{};
  if (trimmed(text).empty()) return absent;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    const std::string name(trimmed(text.substr(from, to - from)));
    from = to + 1;
    const int label = part_label(name);
    if (label == 0 || is_axial(label)) {
      std::string limbs;
      for (std::size_t n = 1; n < parts.size(); ++n)
        if (!is_axial(static_cast<int>(n))) limbs += (limbs.empty() ? "" : ", ") + std::string(parts[n].name);
      return bad_use(fmt::format("--absent {}", name),
                     fmt::format("is not a part that a body may lack; choose from {}", limbs));
    }
    absent[static_cast<std::size_t>(label)] = true;
  }
  // a limb part's parent precedes it in the list
  for (std::size_t n = 1; n < parts.size(); ++n)
    absent[n] = absent[n] || absent[static_cast<std::size_t>(part_label(parts[n].parent))];
  return absent;
}

std::string in_text(const AbsentParts& absent) {
  std::string text;
  for (std::size_t n = 1; n < parts.size(); ++n)
    if (absent[n] && !absent[static_cast<std::size_t>(part_label(parts[n].parent))])
      text += (text.empty() ? "" : ",") + std::string(parts[n].name);
  return text;
}

bool any_absent(const AbsentParts& absent) {
  return std::ranges::any_of(absent, [](bool one) { return one; });
}

void leave_out(const AbsentParts& absent, std::vector<std::uint8_t>& labels) {
  if (!any_absent(absent)) return;
  std::array<std::uint8_t, 256> present{};
  for (std::size_t n = 0; n < parts.size(); ++n) {
    std::size_t part = n;
    while (absent[part]) part = static_cast<std::size_t>(part_label(parts[part].parent));
    present[n] = static_cast<std::uint8_t>(part);
  }
  for (std::uint8_t& label : labels) label = present[label];
}

Result<void> check_given(const AbsentParts& absent, const Landmarks& given) {
  for (std::size_t n = 1; n < parts.size(); ++n)
    if (absent[n] && given.contains(parts[n].joint))
      return bad_use(
          "landmarks",
          fmt::format("{} is given although --absent says that {} is missing; leave one of the two out",
                      parts[n].joint, parts[n].name));
  return {};
}

bool is_absent(const AbsentParts& absent, std::string_view stem, std::string_view side) {
  return absent[static_cast<std::size_t>(part_label(std::string(stem) + std::string(side)))];
}

}  // namespace borelli
