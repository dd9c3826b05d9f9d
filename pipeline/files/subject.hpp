// Who was scanned, as far as the table needs it: the sex whose published values stand beside.
#pragma once

#include <string>
#include <vector>

#include "segmentation/files/read.hpp"

namespace borelli {

/// Younger than this, published values of adults are not put beside on a header's word alone, years.
inline constexpr double adult_from = 16;

struct Subject {
  std::string sex;                 ///< "male", "female", or empty: nothing to compare with
  std::vector<std::string> notes;  ///< what was taken from the header, or contradicts the user, a line each
};

/// The user's word (`said_sex`, empty where there is none) goes before the header's.
Subject subject_of(const ScannedVolume& scan, const std::string& said_sex);

}  // namespace borelli
