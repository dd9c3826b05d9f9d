#include "tests/suite/body_landmarks.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>

#include "segmentation/joints/spheres.hpp"
#include "tests/suite/labelled_body.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

Vector3d mean(const Points& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / std::max<double>(1, double(points.size()));
}

Points those(const Points& points, const std::function<bool(const Vector3d&)>& keep) {
  Points out;
  std::copy_if(points.begin(), points.end(), std::back_inserter(out), keep);
  return out;
}

const Vector3d& extreme(const Points& points, const Vector3d& along) {
  return *std::max_element(points.begin(), points.end(),
                           [&](const Vector3d& a, const Vector3d& b) { return a.dot(along) < b.dot(along); });
}

double lowest(const Points& points) { return extreme(points, -Vector3d::UnitZ()).z(); }
double highest(const Points& points) { return extreme(points, Vector3d::UnitZ()).z(); }

// Points of `a` that have one of `b` within `reach`.
Points near(const Points& a, const Points& b, double reach) {
  Vector3d low = Vector3d::Constant(1e9), high = -low;
  for (const Vector3d& p : b) low = low.cwiseMin(p), high = high.cwiseMax(p);
  low.array() -= reach, high.array() += reach;
  const Points candidates =
      those(a, [&](const Vector3d& p) { return (p - low).minCoeff() >= 0 && (high - p).minCoeff() >= 0; });
  Vector3d la = Vector3d::Constant(1e9), ha = -la;
  for (const Vector3d& p : candidates) la = la.cwiseMin(p), ha = ha.cwiseMax(p);
  const Points others = those(
      b, [&](const Vector3d& p) { return (p - la).minCoeff() >= -reach && (ha - p).minCoeff() >= -reach; });
  return those(candidates, [&](const Vector3d& p) {
    return std::any_of(others.begin(), others.end(),
                       [&](const Vector3d& q) { return (p - q).squaredNorm() <= reach * reach; });
  });
}

Vector3d border(const Points& a, const Points& b, double reach) {
  const Points na = near(a, b, reach), nb = near(b, a, reach);
  return 0.5 * (mean(na) + mean(nb));
}

class Bones {
 public:
  explicit Bones(const LabelledBody& body) : body_(body) { middle_ = mean(of(41, 42)).x(); }
  // Voxels' centres of organs first to last.
  Points of(int first, int last) const {
    Points out;
    for (std::size_t n = 0; n < body_.voxel.size(); ++n)
      if (body_.is(n, first, last)) out.push_back(body_.centre(n));
    return out;
  }
  Points side(int first, int last, bool left) const {
    return those(of(first, last), [&](const Vector3d& p) { return (p.x() > middle_) == left; });
  }
  // Middles of the faces in x and y between voxels of these organs and others.
  Points faces(int first, int last, bool left) const {
    Points out;
    const Grid& g = body_.grid;
    for (std::size_t n = 0; n < body_.voxel.size(); ++n) {
      if (!body_.is(n, first, last) || (body_.centre(n).x() > middle_) != left) continue;
      for (const int axis : {0, 1})
        for (const int sign : {-1, 1}) {
          const std::int64_t o = body_.voxel[n] + sign * (axis ? g.size[0] : 1);
          const auto m = body_.number[static_cast<std::size_t>(o)];
          if (m && body_.is(m - 1, first, last)) continue;
          out.push_back(body_.centre(n) + 0.5 * sign * g.axes.col(axis));
        }
    }
    return out;
  }
  // Voxels' centres of a part, bone and flesh.
  Points part(const std::string& name) const {
    Points out;
    for (std::size_t n = 0; n < body_.voxel.size(); ++n)
      if (body_.owner[n] == static_cast<std::size_t>(part_label(name))) out.push_back(body_.centre(n));
    return out;
  }
  double middle() const { return middle_; }

 private:
  const LabelledBody& body_;
  double middle_ = 0;
};

// Ball that most faces lie on, from a first guess.
std::optional<FoundSphere> robust_ball(const Points& faces, Vector3d centre, double radius) {
  std::optional<FoundSphere> ball;
  for (const double within : {8.0, 5.0, 3.5, 2.5, 2.5, 2.5, 2.5}) {
    const Points kept =
        those(faces, [&](const Vector3d& p) { return std::abs((p - centre).norm() - radius) <= within; });
    if (kept.size() < 20) return ball;
    const auto fitted = sphere_through(kept);
    if (!fitted) return ball;
    ball = fitted;
    centre = fitted->centre, radius = std::clamp(fitted->radius, 17.0, 30.0);
  }
  return ball;
}

void mark(Landmarks& out, const std::string& name, const Vector3d& point, double deviation,
          double radius = 0) {
  out[name] = {point, deviation, radius, "exact"};
}

const Vector3d& farthest(const Points& points, const Vector3d& from) {
  return *std::max_element(points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
    return (a - from).squaredNorm() < (b - from).squaredNorm();
  });
}

// Ends along the longest horizontal axis of a slab: first the one to `lateral`.
std::array<Vector3d, 2> ends_across(const Points& slab, const Vector3d& lateral) {
  const Vector3d c = mean(slab);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Vector3d& p : slab) {
    const Eigen::Vector2d d = (p - c).head<2>();
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  Vector3d axis(solver.eigenvectors()(0, 1), solver.eigenvectors()(1, 1), 0);
  if (axis.dot(lateral) < 0) axis = -axis;
  const auto tip = [&](const Vector3d& along) {
    const double most = extreme(slab, along).dot(along);
    return mean(those(slab, [&](const Vector3d& p) { return p.dot(along) >= most - 3; }));
  };
  return {tip(axis), tip(-axis)};
}

void arm(const Bones& bones, bool left, Landmarks& out) {
  const std::string at = left ? "_left" : "_right";
  const Points upper = bones.side(13, 15, left), lower = bones.side(16, 18, left),
               fore = bones.side(19, 21, left), hand = bones.side(22, 23, left),
               scapula = bones.side(45, 46, left);
  const double top = highest(upper);
  const Points head = those(upper, [&](const Vector3d& p) { return p.z() > top - 32; });
  const Points faces = those(bones.faces(13, 15, left), [&](const Vector3d& p) { return p.z() > top - 40; });
  if (const auto ball = robust_ball(faces, mean(head), 23))
    mark(out, "shoulder" + at, ball->centre, 2, ball->radius);
  else
    mark(out, "shoulder" + at, mean(head), 5, 23);
  const double end = lowest(lower);
  const Points slab = those(lower, [&](const Vector3d& p) { return p.z() > end + 8 && p.z() < end + 40; });
  const auto [lateral, medial] =
      ends_across(slab, Vector3d(left ? 1 : -1, -0.3, 0));  // hanging arms turn the lateral one forwards
  mark(out, "elbow_lateral" + at, lateral, 4), mark(out, "elbow_medial" + at, medial, 4);
  mark(out, "elbow" + at, mean(near(lower, fore, 8)), 3, 12);
  mark(out, "wrist" + at, border(fore, hand, 9), 3);
  const Vector3d wrist = out.at("wrist" + at).point;
  const Vector3d tip = farthest(bones.part("hand" + at), wrist);
  mark(out, "dactylion_3" + at, tip, 5);
  const Vector3d along = (tip - wrist).normalized();
  const double length = (tip - wrist).norm();
  const Points knuckles =
      those(hand, [&](const Vector3d& p) { return std::abs((p - wrist).dot(along) - 0.46 * length) < 8; });
  mark(out, "metacarpale_3" + at, mean(knuckles), 6);
}

void leg(const Bones& bones, bool left, Landmarks& out) {
  const std::string at = left ? "_left" : "_right";
  const Vector3d lateral(left ? 1 : -1, 0, 0);
  const Points pelvis = bones.of(41, 42), upper = bones.side(28, 30, left), lower = bones.side(31, 33, left),
               tibia = bones.side(34, 36, left);
  const Points at_socket = near(upper, pelvis, 16);
  const Points faces = near(bones.faces(28, 30, left), at_socket, 12);
  if (const auto ball = robust_ball(faces, mean(at_socket), 23))
    mark(out, "hip" + at, ball->centre, 1.5, ball->radius);
  else
    mark(out, "hip" + at, mean(at_socket), 5, 23);

  const double end = lowest(lower);
  const Points slab = those(lower, [&](const Vector3d& p) { return p.z() > end + 8 && p.z() < end + 40; });
  const auto [outer, inner] = ends_across(slab, lateral);
  mark(out, "knee_lateral" + at, outer, 4), mark(out, "knee_medial" + at, inner, 4);
  const Points condyles = those(lower, [&](const Vector3d& p) { return p.z() < end + 36; });
  Vector3d knee = 0.5 * (outer + inner);
  knee.y() = mean(condyles).y(), knee.z() = end + 20;
  mark(out, "knee" + at, knee, 3);

  const double sole = lowest(tibia);
  const Points malleoli = those(tibia, [&](const Vector3d& p) { return p.z() < sole + 30; });
  const auto side = [&](const Vector3d& along) {
    const double most = extreme(malleoli, along).dot(along);
    return mean(those(malleoli, [&](const Vector3d& p) { return p.dot(along) > most - 4; }));
  };
  const Vector3d ankle = 0.5 * (side(lateral) + side(-lateral));
  mark(out, "ankle" + at, ankle, 8);
  const auto tip = [&](const Vector3d& along) {
    const Points half = those(malleoli, [&](const Vector3d& p) { return (p - ankle).dot(along) > 10; });
    return mean(those(half, [low = lowest(half)](const Vector3d& p) { return p.z() < low + 4; }));
  };
  mark(out, "lateral_malleolus" + at, tip(lateral), 10),
      mark(out, "medial_malleolus" + at, tip(-lateral), 10);
  const Points foot = bones.part("foot" + at);
  mark(out, "toe_tip" + at, farthest(foot, ankle), 5);
  mark(out, "heel" + at, farthest(foot, out.at("toe_tip" + at).point), 8);
  const Points half = those(pelvis, [&, low = lowest(pelvis), high = highest(pelvis)](const Vector3d& p) {
    return p.z() > 0.5 * (low + high) && (p.x() > bones.middle()) == left;
  });
  mark(out, "asis" + at, extreme(half, -Vector3d::UnitY()), 4);
  mark(out, "psis" + at, extreme(half, Vector3d::UnitY()), 5);
}

// The navel: of the front skin within 60 mm of a level and 25 mm of the midline, the place that lies deepest behind its
// surroundings, 20 mm above, below and beside it.
Vector3d deepest_dent(const LabelledBody& body, const Vector3d& about) {
  constexpr double far = 60, aside = 25, around = 20;  // mm
  const Grid& g = body.grid;
  const auto front = [&](std::int64_t i, std::int64_t k) {
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      if (body.number[g.offset(i, j, k)]) return g.point(i, j, k).y();
    return 1e9;
  };
  const auto index = [&](double mm, int axis) {
    return std::lround((mm - g.origin[axis]) / g.axes(axis, axis));
  };
  const auto di = std::lround(around / g.axes(0, 0)), dk = std::lround(around / g.axes(2, 2));
  Vector3d out = about;
  double deepest = 0;
  for (auto k = index(about.z() - far, 2); k <= index(about.z() + far, 2); ++k)
    for (auto i = index(about.x() - aside, 0); i <= index(about.x() + aside, 0); ++i) {
      const double y = front(i, k);
      // against the line through opposite surroundings, so that slopes do not count
      const double depth = std::min(y - 0.5 * (front(i - di, k) + front(i + di, k)),
                                    y - 0.5 * (front(i, k - dk) + front(i, k + dk)));
      if (depth > deepest) deepest = depth, out = {g.point(i, 0, 0).x(), y, g.point(0, 0, k).z()};
    }
  return out;
}

}  // namespace

Landmarks find_body_landmarks(const LabelledBody& body) {
  const Bones bones(body);
  Landmarks out;
  for (const bool left : {true, false}) arm(bones, left, out), leg(bones, left, out);
  mark(out, "mid_hip", 0.5 * (out.at("hip_left").point + out.at("hip_right").point), 1.5);

  const Points cervical = bones.of(47, 48), thoracic = bones.of(49, 50), lumbar = bones.of(51, 52),
               sacrum = bones.of(53, 54), cord = bones.of(126, 126), sternum = bones.of(55, 56);
  // vertebral bodies: in front of the spinal cord, or below it before the hindmost 55 % of the column
  const auto bodies_at = [&](double z) {
    const auto at_level = [&](const Vector3d& p) { return std::abs(p.z() - z) < 12; };
    Points all;
    for (const Points* region : {&cervical, &thoracic, &lumbar, &sacrum})
      std::ranges::copy_if(*region, std::back_inserter(all), at_level);
    const double front = extreme(all, -Vector3d::UnitY()).y(), back = extreme(all, Vector3d::UnitY()).y();
    const Points canal = those(cord, at_level);
    const double end = canal.empty() ? front + 0.45 * (back - front) : extreme(canal, -Vector3d::UnitY()).y();
    Vector3d c = mean(those(all, [&](const Vector3d& p) { return p.y() < end; }));
    c.z() = z;
    return c;
  };
  const auto disc = [&](const Points& a, const Points& b) { return bodies_at(border(a, b, 9).z()); };
  mark(out, "neck", disc(cervical, thoracic), 4);
  mark(out, "t12_l1", disc(thoracic, lumbar), 4);
  mark(out, "l5_s1", disc(lumbar, sacrum), 5);
  const Points c7 = those(cervical, [low = lowest(cervical)](const Vector3d& p) { return p.z() < low + 25; });
  mark(out, "cervicale", extreme(c7, Vector3d::UnitY()), 5);
  // the manubrium's two upper corners lie higher than the notch between them
  const double top_of_bone = highest(sternum), end_of_bone = lowest(sternum);
  const double middle = mean(those(sternum, [&](const Vector3d& p) { return p.z() > top_of_bone - 30; })).x();
  mark(out, "suprasternale",
       extreme(those(sternum, [&](const Vector3d& p) { return std::abs(p.x() - middle) < 8; }),
               Vector3d::UnitZ()),
       4);
  mark(out, "xiphion", mean(those(sternum, [&](const Vector3d& p) { return p.z() < end_of_bone + 4; })), 5);
  mark(out, "spine_upper", bodies_at(out.at("xiphion").point.z()), 5);
  const double low = lowest(lumbar), high = highest(lumbar);
  mark(out, "l4_l5", bodies_at(low + 0.2 * (high - low)), 6);
  Points top;
  for (std::size_t n = 0; n < body.voxel.size(); ++n) {
    const Vector3d p = body.centre(n);
    if (top.empty() || p.z() > top[0].z() + 1) top.clear();
    if (top.empty() || p.z() > top[0].z() - 1) top.push_back(p);
  }
  mark(out, "vertex", mean(top), 5);
  const Vector3d navel = deepest_dent(body, bodies_at(low + 0.3 * (high - low)));
  mark(out, "omphalion", navel, 4);
  mark(out, "spine_lower", bodies_at(navel.z()), 4);
  return out;
}

}  // namespace borelli::suite
