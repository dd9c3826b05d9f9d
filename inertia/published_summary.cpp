#include "inertia/published_summary.hpp"

#include <fmt/core.h>

#include <cmath>

namespace borelli {

std::vector<PublishedSummary> published_summaries(const InertiaTable& table) {
  std::vector<PublishedSummary> all;
  for (const auto name : published_tables) {
    PublishedSummary summary;
    summary.table = name;
    double sum = 0, squares = 0;
    for (const InertiaRow& row : table.rows) {
      const Comparison beside = compare(table, row, name);
      if (!beside.published || !beside.mass) {
        const std::string why = !beside.published ? beside.why_not : "not every part is there and whole";
        if (summary.why_not.find(why) == std::string::npos)
          summary.why_not += (summary.why_not.empty() ? "" : "; ") + why;
        continue;
      }
      const double off = 100 * (table.share(row) / beside.published->mass_share - 1);
      ++summary.parts, sum += off, squares += off * off;
      if (std::abs(off) > std::abs(summary.farthest_pct))
        summary.farthest = row.part, summary.farthest_pct = off;
    }
    if (summary.parts > 0) {
      summary.mean_pct = sum / summary.parts, summary.rms_pct = std::sqrt(squares / summary.parts);
      summary.why_not.clear();
    }
    all.push_back(std::move(summary));
  }
  return all;
}

std::string in_words(const PublishedSummary& s) {
  if (s.parts == 0) return fmt::format("{}: no part is comparable in mass ({})", s.table, s.why_not);
  return fmt::format(
      "{}: masses of {} parts differ by {:+.1f} % on average, {:.1f} % rms, {} most ({:+.1f} %)", s.table,
      s.parts, s.mean_pct, s.rms_pct, s.farthest, s.farthest_pct);
}

}  // namespace borelli
