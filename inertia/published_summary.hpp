// Compares a body's masses with each published table, in one line per table.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "inertia/table.hpp"

namespace borelli {

/// Names of the published tables, in display order.
inline constexpr std::array<std::string_view, 4> published_tables{"deleva1996", "dumas2007", "winter2009",
                                                                  "zatsiorsky2002"};

/// Difference of the parts' mass shares from one published table, in percent of the published share.
struct PublishedSummary {
  std::string table;
  int parts = 0;         ///< number of parts that compare
  double mean_pct = 0;   ///< mean of (measured / published - 1), percent
  double rms_pct = 0;    ///< root mean square of the same
  std::string farthest;  ///< the part with the largest difference
  double farthest_pct = 0;
  std::string why_not;  ///< reasons if no part compares, each once
};
/// One for each of published_tables.
std::vector<PublishedSummary> published_summaries(const InertiaTable& table);

/// E.g. "deleva1996: masses of 16 parts differ by +0.8 % on the mean, 4.1 % rms, hand_left most (-9.3 %)".
std::string in_words(const PublishedSummary& summary);

}  // namespace borelli
