// Text from a file as it may stand in an error message.
#pragma once

#include <string>
#include <string_view>

namespace borelli {

/// At most `most` bytes of `text`, then "..."; bytes other than printable ASCII as "<hex>".
std::string printable(std::string_view text, std::size_t most = 40);

}  // namespace borelli
