#include "segmentation/joints/joints_along_path.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace borelli {
namespace {

using Eigen::Vector3d;

// position of the largest section in a stretch of the path; 0 if the path ends before the stretch
double widest(const LimbPath& path, double from, double to) {
  if (path.length() < from) return 0;
  std::size_t best = path.index(from);
  for (std::size_t n = best; n <= path.index(to); ++n)
    if (path.section[n] > path.section[best]) best = n;
  return LimbPath::spacing * static_cast<double>(best);
}

double narrowest(const LimbPath& path, double from, double to) {
  std::size_t best = path.index(from);
  for (std::size_t n = best; n <= path.index(to); ++n)
    if (path.section[n] < path.section[best]) best = n;
  return LimbPath::spacing * static_cast<double>(best);
}

double section(const LimbPath& path, double s) { return path.section[path.index(s)]; }

// the same as a mean over 15 mm: on coarse voxels single sections of slender bones jump
double smooth_section(const LimbPath& path, double s) {
  double sum = 0;
  for (int n = -2; n <= 2; ++n) sum += section(path, s + n * LimbPath::spacing);
  return sum / 5;
}

double middling_section(const LimbPath& path, double from, double to) {
  std::vector<double> all(path.section.begin() + static_cast<std::ptrdiff_t>(path.index(from)),
                          path.section.begin() + static_cast<std::ptrdiff_t>(path.index(to)) + 1);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

// the waist between a broad place and another one within `reach` of it: the joint's line if no gap is visible
// between two broad bone ends
std::optional<double> waist_near(const LimbPath& path, double broad, double reach) {
  const double at = section(path, broad);
  std::optional<double> best;
  double rise = 0.2 * at;
  for (std::size_t q = path.index(broad - reach); q <= path.index(broad + reach); ++q) {
    const double s = LimbPath::spacing * static_cast<double>(q);
    const double low = narrowest(path, std::min(s, broad), std::max(s, broad));
    if (path.section[q] < 0.6 * at || path.section[q] - section(path, low) <= rise) continue;
    rise = path.section[q] - section(path, low);
    best = low;
  }
  return best;
}

// middle of the gap between bones that is nearest to s, within `reach` of it
std::optional<double> gap_near(const LimbPath& path, double s, double reach) {
  std::optional<double> best;
  for (std::size_t n = path.index(s - reach); n <= path.index(s + reach); ++n) {
    if (path.off_bone[n] <= 0) continue;
    std::size_t end = n;
    while (end + 1 < path.off_bone.size() && path.off_bone[end + 1] > 0) ++end;
    const double middle = 0.5 * LimbPath::spacing * static_cast<double>(n + end);
    if (!best || std::abs(middle - s) < std::abs(*best - s)) best = middle;
    n = end;
  }
  return best;
}

// True if sections along a forearm's shaft, which should be alike, jump: the voxels are too coarse.
bool is_noisy(const LimbPath& path, double from, double to) {
  const double usual = middling_section(path, from, to);
  double off = 0;
  for (double s = from; s <= to; s += LimbPath::spacing)
    off = std::max(off, std::abs(smooth_section(path, s) - usual));
  return off > 0.2 * usual;
}

// The first place in a stretch of an arm's path with little bone (below 0.4 `thin`, the shaft's section) and
// a hand's bones soon beyond. It locates a wrist where noise hides all finer detail.
std::optional<double> notch_before_hand(const LimbPath& path, double from, double to, double thin,
                                        double hand) {
  for (double s = from; s <= std::min(to, path.length() - hand); s += LimbPath::spacing) {
    if (smooth_section(path, s) >= 0.4 * thin) continue;
    while (s < to && smooth_section(path, s + LimbPath::spacing) < smooth_section(path, s))
      s += LimbPath::spacing;
    for (double beyond = s; beyond <= s + hand; beyond += LimbPath::spacing)
      if (smooth_section(path, beyond) > 0.6 * thin) return s;
    return std::nullopt;
  }
  return std::nullopt;
}

// Index of the middle of the valley about section n: midway between the places beside it where the section
// reaches half way up to `flank`. Midway is measured in space, since a gap lengthens the weighted path.
std::size_t middle_of_valley(const LimbPath& path, std::size_t n, double flank) {
  const double level = 0.5 * (path.section[n] + flank);
  std::size_t from = n, to = n;
  while (from > 0 && path.section[from] < level) --from;
  while (to + 1 < path.section.size() && path.section[to] < level) ++to;
  const Vector3d middle = 0.5 * (path.points[from] + path.points[to]);
  for (std::size_t q = from; q <= to; ++q)
    if ((path.points[q] - middle).norm() < (path.points[n] - middle).norm()) n = q;
  return n;
}

}  // namespace

std::vector<WristPlace> wrist_places(const LimbPath& path, const Vector3d& elbow, double scale) {
  constexpr double flanks = 45, bottom = 9;  // mm to each side of a valley
  constexpr double shallow = 0.75;           // largest section of a valley, relative to its lower flank
  // Forearm of a body of usual size, mm; `scale` makes women too tall.
  constexpr double forearm = 262, forearm_varies = 0.07;
  constexpr double shortest = 0.72, longest = 1.25;  // of a forearm
  constexpr double depth_tells = 1.5;                // log odds of a gap against no dip
  const std::size_t count = path.points.size();
  std::vector<double> beyond(count, 0);  // along the bones to the path's end, mm
  for (std::size_t n = count - 1; n-- > 0;)
    beyond[n] = beyond[n + 1] + (path.points[n + 1] - path.points[n]).norm();
  // least and largest section from n on, forwards or backwards, up to `reach` mm along the bones
  const auto sections = [&](std::size_t n, bool forwards, double reach) {
    std::size_t end = n;
    while (forwards ? end + 1 < count : end > 0) {
      const std::size_t next = forwards ? end + 1 : end - 1;
      if (std::abs(beyond[next] - beyond[n]) >= reach) break;
      end = next;
    }
    const auto [first, last] = std::minmax(n, end);
    const auto begin = path.section.begin();
    const auto [least, most] = std::minmax_element(begin + static_cast<std::ptrdiff_t>(first),
                                                   begin + static_cast<std::ptrdiff_t>(last) + 1);
    return std::pair(*least, *most);
  };
  std::vector<WristPlace> places;
  std::size_t after = 0;  // the last valley's far side
  for (std::size_t n = path.index(150 * scale); n + 1 < count; ++n) {
    const double off = (path.points[n] - elbow).norm() / (forearm * scale);
    if (n <= after || off < shortest || off > longest || beyond[n] < flanks * scale) continue;
    const double low = path.section[n];
    if (sections(n, false, bottom).first < low || sections(n, true, bottom).first < low) continue;
    const double flank =
        std::min(sections(n, false, flanks * scale).second, sections(n, true, flanks * scale).second);
    if (low >= shallow * flank) continue;
    const std::size_t at = middle_of_valley(path, n, flank);
    after = std::max(n, at);
    while (after + 1 < count && path.section[after] < 0.5 * (low + flank)) ++after;
    const double length = (path.points[at] - elbow).norm();
    const double unusual = (length / (forearm * scale) - 1) / forearm_varies;
    const double unlike =
        path.cut ? 0 : (beyond[at] / (beyond[at] + length) - hand_share) / hand_share_varies;
    places.push_back(
        {path.points[at], depth_tells * (1 - low / flank) - 0.5 * (unusual * unusual + unlike * unlike)});
  }
  return places;
}

std::optional<UsualWrist> usual_wrist(const LimbPath& path, const Vector3d& elbow) {
  const auto off = [&](const Vector3d& p) { return (p - elbow).squaredNorm(); };
  const auto from = std::min_element(path.points.begin(), path.points.end(),
                                     [&](const Vector3d& p, const Vector3d& q) { return off(p) < off(q); });
  double length = 0;
  for (auto p = from; std::next(p) != path.points.end(); ++p) length += (*std::next(p) - *p).norm();
  constexpr double shortest = 200;  // mm
  if (length < shortest) return std::nullopt;
  double left = (1 - hand_share) * length;
  auto p = from;
  for (; std::next(p) != path.points.end() && left > 0; ++p) left -= (*std::next(p) - *p).norm();
  return UsualWrist{*p, length};
}

JointsAlongPath leg_joints(const LimbPath& path, double scale) {
  JointsAlongPath joints;
  // without the femoral head, enough shaft must show to distinguish a knee from the upper end of a shank
  const double knee = widest(path, (path.headless ? 60 : 270) * scale, 580 * scale);
  if (knee == 0 || path.length() < knee + 20) return joints;
  const double shaft = narrowest(path, (path.headless ? 15 : 120) * scale, knee);
  if (section(path, knee) < 2 * section(path, shaft)) return joints;
  const auto gap = gap_near(path, knee, 40 * scale), waist = waist_near(path, knee, 70 * scale);
  joints.middle = gap.value_or(waist.value_or(knee));
  joints.middle_seen = gap || waist;

  // beyond the shank's shaft the tibia broadens to the ankle
  const double from = joints.middle + 280 * scale, to = joints.middle + 560 * scale;
  if (path.length() < from + 60) return joints;
  const double shank = middling_section(path, joints.middle + 150 * scale, joints.middle + 340 * scale);
  for (double s = from; s <= std::min(to, path.length() - 60) && joints.end == 0; s += LimbPath::spacing)
    if (smooth_section(path, s) >= 1.4 * shank) joints.end = s + flare_to_ankle * scale;
  if (joints.end > path.length() - 40) joints.end = 0;
  // if the scan's side cuts the shank, its bones look slender, and the broadening is not visible
  for (std::size_t n = path.index(from); n <= path.index(joints.end); ++n)
    if (joints.end > 0 && path.at_edge[n]) joints.end = 0;
  return joints;
}

JointsAlongPath arm_joints(const LimbPath& path, double scale) {
  JointsAlongPath joints;
  const double elbow = widest(path, 200 * scale, 420 * scale);
  if (elbow == 0 || path.length() < elbow + 20) return joints;
  const double shaft = narrowest(path, 60 * scale, elbow);
  if (section(path, elbow) < 1.6 * section(path, shaft)) return joints;
  // no gap visible: the widest place includes trochlea, radial head and olecranon, and lies below the joint's
  // line
  joints.middle = gap_near(path, elbow, 30 * scale).value_or(elbow - 8 * scale);

  const double from = joints.middle + 190 * scale, to = joints.middle + 340 * scale;
  if (path.length() < from + 60) return joints;
  const double thin = middling_section(path, joints.middle + 60 * scale, from);
  // the radius's broad end, then the joint's line; a slender radius gives only the widest place nearby
  double last = std::min(to, path.length() - 20), waist = 0;
  // beyond the forearm's bones, where the section falls to half, a hand's knuckles may be as broad
  for (double s = from; s < last; s += LimbPath::spacing)
    if (section(path, s) < 0.5 * thin) waist = narrowest(path, s, s + 15 * scale), last = s;
  double broad = 0;
  const auto notch = is_noisy(path, joints.middle + 90 * scale, from)
                         ? notch_before_hand(path, joints.middle + 225 * scale, to, thin, 45 * scale)
                         : std::nullopt;
  if (notch) broad = widest(path, *notch - 45 * scale, *notch), waist = *notch;
  for (double s = from; s <= last && broad == 0; s += LimbPath::spacing)
    if (smooth_section(path, s) >= 1.25 * thin) broad = widest(path, s, s + 24 * scale);
  if (broad == 0) broad = widest(path, std::min(joints.middle + 200 * scale, last), last);
  // in a bent wrist the carpal waist is less narrow than the hand's own farther on
  constexpr double carpus = 36;
  if (waist > broad + carpus * scale) {
    const double low = narrowest(path, broad, broad + carpus * scale);
    waist = section(path, low) < 0.6 * section(path, broad) ? low : 0;
  }
  const auto gap = gap_near(path, broad, 24 * scale);
  joints.end = gap.value_or(waist > 0 ? waist : broad + 9 * scale);
  // if the scan cuts the arm, a broad place near its end is no wrist without a hand beyond
  constexpr double hand_in_view = 40;
  if (path.cut && !gap && path.length() < joints.end + hand_in_view * scale) joints.end = 0;
  return joints;
}

}  // namespace borelli
