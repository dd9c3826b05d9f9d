// The scanned person as far as the table needs it: the sex selects the published values to compare with.
#pragma once

#include <string>
#include <vector>

#include "segmentation/files/read.hpp"

namespace borelli {

/// Age in years below which a header's sex alone does not select published values of adults.
inline constexpr double adult_from = 16;

struct Subject {
  std::string sex;                 ///< "male", "female", or empty: nothing to compare with
  std::vector<std::string> notes;  ///< what came from the header or contradicts the user, one line each
};

/// The user's `said_sex` (empty: not stated) overrides the header's.
Subject subject_of(const ScannedVolume& scan, const std::string& said_sex);

}  // namespace borelli
