#include "pipeline/motion/planted_feet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "dynamics/inverse/marker_fit.hpp"
#include "pipeline/motion/foot_contact.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double near_level = 0.015;     // m
constexpr double slow = 0.3;             // m/s
constexpr double least_stance = 0.1;     // s
constexpr double frame_arm = 0.1;        // m, of the points that hold a solid's pose
constexpr double standing_weight = 100;  // of a sole point that stands, beside 1 of those

/// A sole point in its foot, and over time.
struct SolePoint {
  int foot = -1;           ///< solid
  std::size_t number = 0;  ///< in the foot's list
  Vector3d place;          ///< in the body's foot, m
  Matrix3Xd path;          ///< #times: world, in the recorded person's size, m
  std::vector<char> stands;
  double level = 0;  ///< m, its lowest height in the motion (lowest_of)
  std::vector<double>
      levels;  ///< m, by time: `level`, or higher by the step while the foot carries a load on one
  std::vector<double> steps;  ///< m, by time: height of the step above the lowest floor; 0: none
};

/// The height of a step, m, from a height above the lowest floor: below 5 cm it is no step.
double step_of(double height) { return height < 0.05 ? 0 : height; }

/// A foot that stands from one time to another, and the flat pose that it is held in.
struct Stance {
  int foot = -1;
  std::size_t first = 0, last = 0;
  double height = 0;  ///< m, of the floor or step it stands on, in the body's world
  Pose pose;
};

std::vector<SolePoint> sole_points(const System& body, const FootSoles& soles) {
  std::vector<SolePoint> out;
  SolidPoses poses(body);
  poses.update(0, body.initial.q);
  for (const auto& [foot, points] : soles) {
    const int solid = solid_index(body, foot);
    if (solid < 0) continue;
    for (std::size_t k = 0; k < points.size(); ++k)
      out.push_back({solid, k, poses.of(solid).inverse() * points[k], {}, {}, 0, {}});
  }
  return out;
}

/// Removes runs of `value` that are shorter than the least stance.
void drop_short(std::vector<char>& flags, const std::vector<double>& times, char value) {
  for (std::size_t i = 0; i < flags.size();) {
    std::size_t end = i;
    while (end < flags.size() && flags[end] == flags[i]) ++end;
    const bool inside = i > 0 && end < flags.size();
    if (flags[i] == value && inside && times[end - 1] - times[i] < least_stance)
      std::fill(flags.begin() + std::ptrdiff_t(i), flags.begin() + std::ptrdiff_t(end), char(!value));
    i = end;
  }
}

/// The middle of the lowest tenth.
double lowest_of(std::vector<double> heights) {
  std::ranges::sort(heights);
  return heights[heights.size() / 20];
}

/// Calls visit(first, end) for each unbroken run of set flags.
template <class Visit>
void for_each_run(const std::vector<char>& flags, const Visit& visit) {
  for (std::size_t i = 0; i < flags.size();) {
    std::size_t end = i;
    while (end < flags.size() && flags[end] == flags[i]) ++end;
    if (flags[i]) visit(i, end);
    i = end;
  }
}

/// Levels and steps of all points. The lowest floor is that of the lower foot, for each point by itself: the
/// toes of a rigid foot sink when the heel rises. `loaded`: by point and time.
void find_levels(std::vector<SolePoint>& points, const std::vector<std::vector<char>>& loaded) {
  std::map<std::size_t, double> floors;  // by the point's number
  for (std::size_t k = 0; k < points.size(); ++k) {
    SolePoint& point = points[k];
    const auto lowest_within = [&](std::size_t first, std::size_t end) {
      const auto heights = point.path.row(2).segment(Eigen::Index(first), Eigen::Index(end - first));
      return lowest_of({heights.begin(), heights.end()});
    };
    point.level = lowest_within(0, loaded[k].size());
    point.levels.assign(loaded[k].size(), point.level);
    for_each_run(loaded[k], [&](std::size_t first, std::size_t end) {
      std::fill(point.levels.begin() + std::ptrdiff_t(first), point.levels.begin() + std::ptrdiff_t(end),
                point.level + step_of(lowest_within(first, end) - point.level));
    });
    double& floor = floors.emplace(point.number, point.level).first->second;
    floor = std::min(floor, point.level);
  }
  for (SolePoint& point : points)
    for (const double level : point.levels) point.steps.push_back(step_of(level - floors.at(point.number)));
}

/// Height of the floor under a foot above the lowest floor, m: the least of its points' steps, since a load
/// may begin or end with the heel up.
double step_under(int foot, const std::vector<SolePoint>& points, std::size_t i) {
  double least = std::numeric_limits<double>::infinity();
  for (const SolePoint& point : points)
    if (point.foot == foot) least = std::min(least, point.steps[i]);
  return least;
}

void find_standing(SolePoint& point, const std::vector<double>& times) {
  const auto count = Eigen::Index(times.size());
  point.stands.assign(times.size(), false);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index before = std::max<Eigen::Index>(i - 1, 0), after = std::min(i + 1, count - 1);
    const double speed = (point.path.col(after) - point.path.col(before)).norm() /
                         (times[std::size_t(after)] - times[std::size_t(before)]);
    point.stands[std::size_t(i)] =
        point.path(2, i) < point.levels[std::size_t(i)] + near_level && speed < slow;
  }
  drop_short(point.stands, times, false);  // gaps, then blinks
  drop_short(point.stands, times, true);
}

/// At which times a foot carries a measured load.
std::vector<char> loaded_times(const std::string& foot, const std::vector<double>& times,
                               const std::vector<ExternalLoad>& loads) {
  std::vector<char> out(times.size(), false);
  for (const ExternalLoad& load : loads) {
    const std::vector<double>& samples = load.measured.times;
    if (load.body != foot || samples.empty()) continue;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto at = std::ranges::lower_bound(samples, times[i] - 1e-9) - samples.begin();
      if (at < std::ssize(samples) && load.measured.force.col(at).norm() >= least_load) out[i] = true;
    }
  }
  return out;
}

/// Holds a solid's pose by three points.
std::array<Vector3d, 3> frame_points() {
  return {Vector3d(frame_arm * Vector3d::UnitX()), Vector3d(frame_arm * Vector3d::UnitY()),
          Vector3d(frame_arm * Vector3d::UnitZ())};
}

/// The flat pose of a standing foot: mean place and heading where most of its points stand, turned so that
/// these lie at the height of its floor.
Pose flat_pose(const Stance& stance, const std::vector<SolePoint>& points, const std::vector<Pose>& wanted) {
  int most = 0;
  std::vector<int> standing(stance.last - stance.first + 1, 0);
  for (std::size_t i = stance.first; i <= stance.last; ++i) {
    for (const SolePoint& point : points)
      standing[i - stance.first] += point.foot == stance.foot && point.stands[i];
    most = std::max(most, standing[i - stance.first]);
  }
  // each sole point's mean place then, at the floor's height; the rigid placement nearest to these
  std::vector<Vector3d> local, world;
  for (const SolePoint& point : points) {
    if (point.foot != stance.foot) continue;
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (std::size_t i = stance.first; i <= stance.last; ++i)
      if (standing[i - stance.first] == most) sum += wanted[i] * point.place, ++count;
    local.push_back(point.place);
    world.emplace_back(sum.x() / count, sum.y() / count, stance.height);
  }
  Matrix3Xd from(3, std::ssize(local)), to(3, std::ssize(local));
  for (std::size_t k = 0; k < local.size(); ++k)
    from.col(Eigen::Index(k)) = local[k], to.col(Eigen::Index(k)) = world[k];
  if (local.size() < 3) return wanted[(stance.first + stance.last) / 2];
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
  return {T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
}

/// Wanted poses of every solid of the body at every time: the recorded angles, with the path scaled to the
/// body's size.
class WantedPoses {
 public:
  WantedPoses(const System& body, const RecordedPositions& recorded, double ratio, double ground)
      : body_(body), recorded_(recorded), ratio_(ratio), ground_(ground), poses_(body) {}

  VectorXd positions(std::size_t i) const {
    VectorXd q = recorded_.q.row(Eigen::Index(i)).transpose();
    for (const CoordinateInfo& c : body_.coordinates) {
      const int solid = solid_index(body_, c.solid);
      const bool free = body_.bodies[std::size_t(body_.solid_bodies[std::size_t(solid)])].parent == 0;
      if (!free || c.kind != "translation") continue;
      // translations of a free body are along x, y, z in this order
      const auto first = std::ranges::find(body_.coordinates, c.solid, &CoordinateInfo::solid);
      q[c.q_index] = ratio_ * (q[c.q_index] - (c.q_index - first->q_index == 2 ? ground_ : 0));
    }
    return q;
  }
  double ratio() const { return ratio_; }
  Pose of(int solid, std::size_t i) {
    poses_.update(0, positions(i));
    return poses_.of(solid);
  }

 private:
  const System& body_;
  const RecordedPositions& recorded_;
  double ratio_, ground_;
  SolidPoses poses_;
};

std::vector<Stance> stances_of(const std::vector<SolePoint>& points, std::size_t times, WantedPoses& wanted) {
  std::vector<Stance> out;
  std::vector<int> feet;
  for (const SolePoint& point : points)
    if (std::ranges::find(feet, point.foot) == feet.end()) feet.push_back(point.foot);
  for (const int foot : feet) {
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < times; ++i) poses.push_back(wanted.of(foot, i));
    bool before = false;
    for (std::size_t i = 0; i < times; ++i) {
      const bool now = std::ranges::any_of(
          points, [&](const SolePoint& point) { return point.foot == foot && point.stands[i]; });
      if (now && !before) out.push_back({foot, i, i, wanted.ratio() * step_under(foot, points, i), {}});
      if (now) out.back().last = i;
      before = now;
    }
    for (Stance& stance : out)
      if (stance.foot == foot) stance.pose = flat_pose(stance, points, poses);
  }
  return out;
}

/// What a fit follows: three points of each solid, then the soles.
std::vector<FollowedMarker> followed_points(const System& body, const std::vector<SolePoint>& points) {
  std::vector<FollowedMarker> out;
  for (const std::string& solid : body.solids)
    for (const Vector3d& arm : frame_points()) out.push_back({"pose of " + solid, {solid, arm}, 1});
  for (const SolePoint& point : points)
    out.push_back({"sole", {body.solids[std::size_t(point.foot)], point.place}, standing_weight});
  return out;
}

}  // namespace

Result<PlantedFeet> planted_positions(const System& sized, const RecordedPositions& recorded,
                                      const System& body, const FeetOnGround& feet) {
  std::vector<SolePoint> points = sole_points(body, feet.soles);
  const std::size_t count = recorded.times.size();
  // paths of the sole points in the recorded person's size
  SolidPoses poses(sized);
  double ground = std::numeric_limits<double>::infinity();
  for (SolePoint& point : points) point.path.resize(3, Eigen::Index(count));
  for (std::size_t i = 0; i < count; ++i) {
    poses.update(0, recorded.q.row(Eigen::Index(i)).transpose());
    for (SolePoint& point : points)
      point.path.col(Eigen::Index(i)) =
          poses.of(point.foot) * Vector3d(feet.factors[std::size_t(point.foot)] * point.place);
  }
  std::vector<std::vector<char>> loaded;
  for (const SolePoint& point : points)
    loaded.push_back(loaded_times(body.solids[std::size_t(point.foot)], recorded.times, feet.loads));
  find_levels(points, loaded);
  for (SolePoint& point : points) {
    find_standing(point, recorded.times);
    ground = std::min(ground, point.level);
  }
  if (points.empty()) ground = 0;

  WantedPoses wanted(body, recorded, feet.length_ratio, ground);
  const std::vector<Stance> stances = stances_of(points, count, wanted);
  auto fit = MarkerFit::create(body, followed_points(body, points), {}, {.within_ranges = false});
  if (!fit) return tl::unexpected(fit.error());
  PlantedFeet out{recorded, {}};
  for (const SolePoint& point : points) {
    std::vector<double>& floor = out.floors[body.solids[std::size_t(point.foot)]];
    if (!floor.empty()) continue;
    for (std::size_t i = 0; i < count; ++i)
      floor.push_back(feet.length_ratio * step_under(point.foot, points, i));
  }
  VectorXd q = wanted.positions(0);
  for (std::size_t i = 0; i < count; ++i) {
    q = wanted.positions(i);
    SolidPoses at(body);
    at.update(0, q);
    Matrix3Xd targets(3, std::ssize(fit->markers()));
    Eigen::Index m = 0;
    for (std::size_t s = 0; s < body.solids.size(); ++s)
      for (const Vector3d& arm : frame_points()) targets.col(m++) = at.of(int(s)) * arm;
    for (const SolePoint& point : points) {
      const Vector3d here = at.of(point.foot) * point.place;
      targets.col(m).setConstant(std::numeric_limits<double>::quiet_NaN());
      if (here.z() < 0) targets.col(m) = Vector3d(here.x(), here.y(), 0);
      if (point.stands[i])
        for (const Stance& stance : stances)
          if (stance.foot == point.foot && i >= stance.first && i <= stance.last)
            targets.col(m) = stance.pose * point.place;
      ++m;
    }
    const auto frame = fit->fit(0, targets, VectorXd(), q);
    if (!frame) return tl::unexpected(frame.error());
    out.positions.q.row(Eigen::Index(i)) = q.transpose();
  }
  return out;
}

}  // namespace borelli
