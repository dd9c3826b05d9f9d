// How a body stands to the published tables as a whole, in a line for each.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "inertia/table.hpp"

namespace borelli {

/// The published tables by name, in the order in which they are shown.
inline constexpr std::array<std::string_view, 4> published_tables{"deleva1996", "dumas2007", "winter2009",
                                                                  "zatsiorsky2002"};

/// The mass's share of each part that compares, in percent of the published one.
struct PublishedSummary {
  std::string table;
  int parts = 0;         ///< how many compare
  double mean_pct = 0;   ///< mean of (measured / published - 1), percent
  double rms_pct = 0;    ///< root of the mean of its square
  std::string farthest;  ///< the part that differs most
  double farthest_pct = 0;
  std::string why_not;  ///< where no part compares: the reasons, each once
};
std::vector<PublishedSummary> published_summaries(const InertiaTable& table);

/// E.g. "deleva1996: masses of 16 parts differ by +0.8 % on the mean, 4.1 % rms, hand_left most (-9.3 %)".
std::string in_words(const PublishedSummary& summary);

}  // namespace borelli
