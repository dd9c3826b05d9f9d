#include "segmentation/files/segment_overlaps.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace borelli {
namespace {

constexpr double most_overlap = 0.05;  // of the smaller segment
constexpr std::size_t most_named = 4;  // segments, pairs

// "a", "a, b", "a, b, c, d and 3 more"
std::string some_of(const std::vector<std::string>& all) {
  const auto end = all.begin() + std::min(std::ssize(all), static_cast<std::ptrdiff_t>(most_named));
  return fmt::format("{}{}", fmt::join(all.begin(), end, ", "),
                     end == all.end() ? "" : fmt::format(" and {} more", all.end() - end));
}

}  // namespace

void SegmentOverlaps::add(std::int64_t segment, const std::string& name, bool used) {
  segments_[segment] = {name.empty() ? fmt::format("segment {}", segment) : name, used};
}

bool SegmentOverlaps::used(std::int64_t segment) const {
  const auto known = segments_.find(segment);
  return known != segments_.end() && known->second.used;
}

std::int64_t SegmentOverlaps::winner(std::int64_t held, std::int64_t next) {
  if (!of_last_ || last_ != Pair(held, next)) {
    last_ = {held, next};
    const auto [meeting, is_new] = meetings_.try_emplace(last_);
    of_last_ = &meeting->second;
    if (is_new && !segments_.contains(next)) add(next, "", false);
    if (is_new)
      of_last_->winner = held == 0 || used(held) == used(next) ? std::max(held, next)
                         : used(next)                          ? next
                                                               : held;
  }
  ++of_last_->voxels;
  return of_last_->winner;
}

Result<std::vector<std::string>> SegmentOverlaps::warnings(const std::string& path) const {
  std::map<std::string, int> named;
  for (const auto& [number, segment] : segments_)
    if (segment.used && ++named[segment.name] > 1)
      return bad_use(path,
                     fmt::format("has two segments named {}; rename or remove one of them", segment.name));
  std::map<std::int64_t, std::size_t> claimed;
  std::map<Pair, std::size_t> shared;  // by the smaller and the larger number
  for (const auto& [pair, meeting] : meetings_) {
    const auto [held, next] = pair;
    if (held == next) continue;
    claimed[next] += meeting.voxels;
    if (held != 0) shared[std::minmax(held, next)] += meeting.voxels;
  }
  std::map<std::int64_t, std::pair<std::size_t, std::vector<std::string>>> unused;  // what it left to which
  std::size_t voxels = 0;
  std::vector<std::string> pairs, out;
  for (const auto& [pair, count] : shared) {
    const auto [a, b] = pair;
    const std::string &name = segments_.at(a).name, &other = segments_.at(b).name;
    if (used(a) != used(b)) {
      auto& [left, whose] = unused[used(a) ? b : a];
      left += count, whose.push_back(used(a) ? name : other);
      continue;
    }
    const double share =
        static_cast<double>(count) / static_cast<double>(std::min(claimed.at(a), claimed.at(b)));
    if (used(a) && share > most_overlap)
      return bad_use(path, fmt::format("contains segments that overlap: {} and {} by {:.0f} % of the smaller "
                                       "one; remove one of them, or its voxels in the other",
                                       name, other, 100 * share));
    voxels += count, pairs.push_back(name + " and " + other);
  }
  for (const auto& [segment, left] : unused)
    if (out.size() < most_named)
      out.push_back(
          fmt::format("the segment {} is neither a part nor a class of a mapping, so the {} voxels that "
                      "it shares with {} remain theirs",
                      segments_.at(segment).name, left.first, some_of(left.second)));
  if (unused.size() > most_named)
    out.push_back(fmt::format("{} more segments overlap parts or mapped classes and were left out there",
                              unused.size() - most_named));
  if (voxels > 0)
    out.push_back(fmt::format("{} voxels are in two segments ({}); the later segment got them", voxels,
                              some_of(pairs)));
  return out;
}

std::vector<std::int64_t> SegmentOverlaps::emptied() const {
  std::map<std::int64_t, std::size_t> kept;  // modulo 2^64: losses may be counted before claims
  for (const auto& [pair, meeting] : meetings_) {
    const auto [held, next] = pair;
    if (held != next && meeting.winner == next) kept[next] += meeting.voxels, kept[held] -= meeting.voxels;
    if (held != next && meeting.winner == held) kept[next] += 0;
  }
  std::vector<std::int64_t> out;
  for (const auto& [segment, voxels] : kept)
    if (segment != 0 && voxels == 0) out.push_back(segment);
  return out;
}

}  // namespace borelli
