// Formats quoted text and lists of names for error messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// At most `most` bytes of `text`, then "..."; bytes other than printable ASCII as "<hex>".
std::string printable(std::string_view text, std::size_t most = 40);

/// The first `most` names, and how many others there are: "a, b and 3 more".
std::string name_list(const std::vector<std::string>& names, std::size_t most = 12);

}  // namespace borelli
