// Parts that a body lacks, as its user tells (amputation).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/landmarks.hpp"
#include "segmentation/parts.hpp"

namespace borelli {

/// By label: whether the part is told to be absent. What hangs on an absent part is absent, too.
using AbsentParts = std::array<bool, parts.size()>;

/// What notes say of such a part.
inline constexpr std::string_view absent_as_told = "absent as told";

/// "thigh_left,hand_right": these parts and all that hang on them; empty: none. Errors: a name that is no
/// part, or none of a limb.
Result<AbsentParts> parse_absent(std::string_view text);

/// The same parts as text, without those that an absent one implies; empty where none is absent.
std::string in_text(const AbsentParts& absent);

bool any_absent(const AbsentParts& absent);

/// The part by name, e.g. "thigh" and "_left".
bool is_absent(const AbsentParts& absent, std::string_view stem, std::string_view side);

/// Gives labels of absent parts to the part that they hang on.
void leave_out(const AbsentParts& absent, std::vector<std::uint8_t>& labels);

/// Errors: a landmark is given that is the joint of an absent part.
Result<void> check_given(const AbsentParts& absent, const Landmarks& given);

/// For the help of --absent.
inline constexpr const char* absent_help =
    "Parts that the body lacks, e.g. thigh_left,hand_right: with them all that hangs on them; nothing is "
    "looked for there";

}  // namespace borelli
