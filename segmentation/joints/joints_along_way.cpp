#include "segmentation/joints/joints_along_way.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector3d;

// position of the largest section in a stretch of the path; 0 if the path ends before the stretch
double widest(const LimbWay& way, double from, double to) {
  if (way.length() < from) return 0;
  std::size_t best = way.index(from);
  for (std::size_t n = best; n <= way.index(to); ++n)
    if (way.section[n] > way.section[best]) best = n;
  return LimbWay::spacing * static_cast<double>(best);
}

double narrowest(const LimbWay& way, double from, double to) {
  std::size_t best = way.index(from);
  for (std::size_t n = best; n <= way.index(to); ++n)
    if (way.section[n] < way.section[best]) best = n;
  return LimbWay::spacing * static_cast<double>(best);
}

double section(const LimbWay& way, double s) { return way.section[way.index(s)]; }

// the same as a mean over 15 mm: on coarse voxels single sections of slender bones jump
double smooth_section(const LimbWay& way, double s) {
  double sum = 0;
  for (int n = -2; n <= 2; ++n) sum += section(way, s + n * LimbWay::spacing);
  return sum / 5;
}

double middling_section(const LimbWay& way, double from, double to) {
  std::vector<double> all(way.section.begin() + static_cast<std::ptrdiff_t>(way.index(from)),
                          way.section.begin() + static_cast<std::ptrdiff_t>(way.index(to)) + 1);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

// the waist between a broad place and another one within `reach` of it: the joint's line if no gap is visible
// between two broad bone ends
std::optional<double> waist_near(const LimbWay& way, double broad, double reach) {
  const double at = section(way, broad);
  std::optional<double> best;
  double rise = 0.2 * at;
  for (std::size_t q = way.index(broad - reach); q <= way.index(broad + reach); ++q) {
    const double s = LimbWay::spacing * static_cast<double>(q);
    const double low = narrowest(way, std::min(s, broad), std::max(s, broad));
    if (way.section[q] < 0.6 * at || way.section[q] - section(way, low) <= rise) continue;
    rise = way.section[q] - section(way, low);
    best = low;
  }
  return best;
}

// middle of the gap between bones that is nearest to s, within `reach` of it
std::optional<double> gap_near(const LimbWay& way, double s, double reach) {
  std::optional<double> best;
  for (std::size_t n = way.index(s - reach); n <= way.index(s + reach); ++n) {
    if (way.off_bone[n] <= 0) continue;
    std::size_t end = n;
    while (end + 1 < way.off_bone.size() && way.off_bone[end + 1] > 0) ++end;
    const double middle = 0.5 * LimbWay::spacing * static_cast<double>(n + end);
    if (!best || std::abs(middle - s) < std::abs(*best - s)) best = middle;
    n = end;
  }
  return best;
}

// True if sections along a forearm's shaft, which should be alike, jump: the voxels are too coarse.
bool is_noisy(const LimbWay& way, double from, double to) {
  const double usual = middling_section(way, from, to);
  double off = 0;
  for (double s = from; s <= to; s += LimbWay::spacing)
    off = std::max(off, std::abs(smooth_section(way, s) - usual));
  return off > 0.2 * usual;
}

// The first place in a stretch of an arm's path with little bone (below 0.4 `thin`, the shaft's section) and
// a hand's bones soon beyond. It locates a wrist where noise hides all finer detail.
std::optional<double> notch_before_hand(const LimbWay& way, double from, double to, double thin,
                                        double hand) {
  for (double s = from; s <= std::min(to, way.length() - hand); s += LimbWay::spacing) {
    if (smooth_section(way, s) >= 0.4 * thin) continue;
    while (s < to && smooth_section(way, s + LimbWay::spacing) < smooth_section(way, s))
      s += LimbWay::spacing;
    for (double beyond = s; beyond <= s + hand; beyond += LimbWay::spacing)
      if (smooth_section(way, beyond) > 0.6 * thin) return s;
    return std::nullopt;
  }
  return std::nullopt;
}

// Index of the middle of the valley about section n: midway between the places beside it where the section
// reaches half way up to `flank`. Midway is measured in space, since a gap lengthens the weighted path.
std::size_t middle_of_valley(const LimbWay& way, std::size_t n, double flank) {
  const double level = 0.5 * (way.section[n] + flank);
  std::size_t from = n, to = n;
  while (from > 0 && way.section[from] < level) --from;
  while (to + 1 < way.section.size() && way.section[to] < level) ++to;
  const Vector3d middle = 0.5 * (way.points[from] + way.points[to]);
  for (std::size_t q = from; q <= to; ++q)
    if ((way.points[q] - middle).norm() < (way.points[n] - middle).norm()) n = q;
  return n;
}

}  // namespace

std::vector<WristPlace> wrist_places(const LimbWay& way, const Vector3d& elbow, double scale) {
  constexpr double flanks = 45, bottom = 9;  // mm to each side of a valley
  constexpr double shallow = 0.75;           // largest section of a valley, relative to its lower flank
  // Forearm of a body of usual size, mm; `scale` makes women too tall. The hand's bones make up .39 to .43 of
  // forearm and hand, in phantoms and in de Leva (1996).
  constexpr double forearm = 262, forearm_varies = 0.07, share = 0.40, share_varies = 0.025;
  constexpr double shortest = 0.72, longest = 1.25;  // of a forearm
  constexpr double depth_tells = 1.5;                // log odds of a gap against no dip
  const std::size_t count = way.points.size();
  std::vector<double> beyond(count, 0);  // along the bones to the path's end, mm
  for (std::size_t n = count - 1; n-- > 0;)
    beyond[n] = beyond[n + 1] + (way.points[n + 1] - way.points[n]).norm();
  // least and largest section from n on, forwards or backwards, up to `reach` mm along the bones
  const auto sections = [&](std::size_t n, bool forwards, double reach) {
    std::size_t end = n;
    while (forwards ? end + 1 < count : end > 0) {
      const std::size_t next = forwards ? end + 1 : end - 1;
      if (std::abs(beyond[next] - beyond[n]) >= reach) break;
      end = next;
    }
    const auto [first, last] = std::minmax(n, end);
    const auto begin = way.section.begin();
    const auto [least, most] = std::minmax_element(begin + static_cast<std::ptrdiff_t>(first),
                                                   begin + static_cast<std::ptrdiff_t>(last) + 1);
    return std::pair(*least, *most);
  };
  std::vector<WristPlace> places;
  std::size_t after = 0;  // the last valley's far side
  for (std::size_t n = way.index(150 * scale); n + 1 < count; ++n) {
    const double off = (way.points[n] - elbow).norm() / (forearm * scale);
    if (n <= after || off < shortest || off > longest || beyond[n] < flanks * scale) continue;
    const double low = way.section[n];
    if (sections(n, false, bottom).first < low || sections(n, true, bottom).first < low) continue;
    const double flank =
        std::min(sections(n, false, flanks * scale).second, sections(n, true, flanks * scale).second);
    if (low >= shallow * flank) continue;
    const std::size_t at = middle_of_valley(way, n, flank);
    after = std::max(n, at);
    while (after + 1 < count && way.section[after] < 0.5 * (low + flank)) ++after;
    const double length = (way.points[at] - elbow).norm();
    const double unusual = (length / (forearm * scale) - 1) / forearm_varies;
    const double unlike = way.cut ? 0 : (beyond[at] / (beyond[at] + length) - share) / share_varies;
    places.push_back(
        {way.points[at], depth_tells * (1 - low / flank) - 0.5 * (unusual * unusual + unlike * unlike)});
  }
  return places;
}

JointsAlongWay leg_joints(const LimbWay& way, double scale) {
  JointsAlongWay joints;
  // without the femoral head, enough shaft must show to distinguish a knee from the upper end of a shank
  const double knee = widest(way, (way.headless ? 60 : 270) * scale, 580 * scale);
  if (knee == 0 || way.length() < knee + 20) return joints;
  const double shaft = narrowest(way, (way.headless ? 15 : 120) * scale, knee);
  if (section(way, knee) < 2 * section(way, shaft)) return joints;
  const auto gap = gap_near(way, knee, 40 * scale), waist = waist_near(way, knee, 70 * scale);
  joints.middle = gap.value_or(waist.value_or(knee));
  joints.middle_seen = gap || waist;

  // beyond the shank's shaft the tibia broadens to the ankle
  const double from = joints.middle + 280 * scale, to = joints.middle + 560 * scale;
  if (way.length() < from + 60) return joints;
  const double shank = middling_section(way, joints.middle + 150 * scale, joints.middle + 340 * scale);
  for (double s = from; s <= std::min(to, way.length() - 60) && joints.end == 0; s += LimbWay::spacing)
    if (smooth_section(way, s) >= 1.4 * shank) joints.end = s + flare_to_ankle * scale;
  if (joints.end > way.length() - 40) joints.end = 0;
  // if the scan's side cuts the shank, its bones look slender, and the broadening is not visible
  for (std::size_t n = way.index(from); n <= way.index(joints.end); ++n)
    if (joints.end > 0 && way.at_edge[n]) joints.end = 0;
  return joints;
}

JointsAlongWay arm_joints(const LimbWay& way, double scale) {
  JointsAlongWay joints;
  const double elbow = widest(way, 200 * scale, 420 * scale);
  if (elbow == 0 || way.length() < elbow + 20) return joints;
  const double shaft = narrowest(way, 60 * scale, elbow);
  if (section(way, elbow) < 1.6 * section(way, shaft)) return joints;
  // no gap visible: the widest place includes trochlea, radial head and olecranon, and lies below the joint's
  // line
  joints.middle = gap_near(way, elbow, 30 * scale).value_or(elbow - 8 * scale);

  const double from = joints.middle + 190 * scale, to = joints.middle + 340 * scale;
  if (way.length() < from + 60) return joints;
  const double thin = middling_section(way, joints.middle + 60 * scale, from);
  // the radius's broad end, then the joint's line; a slender radius gives only the widest place nearby
  double last = std::min(to, way.length() - 20), waist = 0;
  // beyond the forearm's bones, where the section falls to half, a hand's knuckles may be as broad
  for (double s = from; s < last; s += LimbWay::spacing)
    if (section(way, s) < 0.5 * thin) waist = narrowest(way, s, s + 15 * scale), last = s;
  double broad = 0;
  const auto notch = is_noisy(way, joints.middle + 90 * scale, from)
                         ? notch_before_hand(way, joints.middle + 225 * scale, to, thin, 45 * scale)
                         : std::nullopt;
  if (notch) broad = widest(way, *notch - 45 * scale, *notch), waist = *notch;
  for (double s = from; s <= last && broad == 0; s += LimbWay::spacing)
    if (smooth_section(way, s) >= 1.25 * thin) broad = widest(way, s, s + 24 * scale);
  if (broad == 0) broad = widest(way, std::min(joints.middle + 200 * scale, last), last);
  // in a bent wrist the carpal waist is less narrow than the hand's own farther on
  constexpr double carpus = 36;
  if (waist > broad + carpus * scale) {
    const double low = narrowest(way, broad, broad + carpus * scale);
    waist = section(way, low) < 0.6 * section(way, broad) ? low : 0;
  }
  const auto gap = gap_near(way, broad, 24 * scale);
  joints.end = gap.value_or(waist > 0 ? waist : broad + 9 * scale);
  // if the scan cuts the arm, a broad place near its end is no wrist without a hand beyond
  constexpr double hand_in_view = 40;
  if (way.cut && !gap && way.length() < joints.end + hand_in_view * scale) joints.end = 0;
  return joints;
}

}  // namespace borelli
