// Parts that the user names as missing, after an amputation for example (--absent).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// By label: whether the user names the part as missing. The parts that hang on it are missing too.
using AbsentParts = std::array<bool, parts.size()>;

/// The note of such a part.
inline constexpr std::string_view stated_as_absent = "stated as absent";

/// Parses "thigh_left,hand_right"; "" names none. Parts that hang on a named one are included. Errors: a name
/// that is not a part, or not of a limb.
Result<AbsentParts> parse_absent(std::string_view text);

/// The reverse of parse_absent: the named parts without those that hang on them; "" for none.
std::string in_text(const AbsentParts& absent);

bool any_absent(const AbsentParts& absent);

/// Whether the part `stem` + `side` is absent, e.g. "thigh" and "_left".
bool is_absent(const AbsentParts& absent, std::string_view stem, std::string_view side);

/// Relabels missing parts as their nearest ancestor in the body's tree that is not missing.
void leave_out(const AbsentParts& absent, std::vector<std::uint8_t>& labels);

/// Errors: `given` holds the joint of a missing part.
Result<void> check_given(const AbsentParts& absent, const Landmarks& given);

/// For the help of --absent.
inline constexpr const char* absent_help =
    "Parts that the body lacks, e.g. thigh_left,hand_right; everything beyond them is absent too, and "
    "nothing is searched for there";

}  // namespace borelli
