#include "tests/suite/warped_tissue.hpp"

#include <algorithm>
#include <cmath>

#include "samples/phantom_builder.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector3d;

constexpr std::int16_t muscle_hu = 50, muscle_density = 1050, skin_hu = 90, skin_density = 1090,
                       metal_density = 4430;

bool is_gut(int organ) {
  return organ == 73 || organ == 75 || organ == 77 || organ == 79 || organ == 81 || organ == 83 ||
         organ == 85;
}
bool is_vessel(int organ) { return (organ >= 9 && organ <= 12) || organ == 88; }

void add_contrast(const LabelledBody& body, const Scanner& scanner, WarpedTissue& out) {
  for (std::size_t n = 0; n < out.hu.size(); ++n) {
    if (is_gut(body.organ[n])) out.hu[n] = std::int16_t(out.hu[n] + scanner.gut_hu);
    if (is_vessel(body.organ[n])) out.hu[n] = std::int16_t(out.hu[n] + scanner.vessel_hu);
  }
}

void add_metal_hip(const LabelledBody& body, bool left, WarpedTissue& out) {
  const std::string side = left ? "_left" : "_right";
  const Landmark& hip = body.landmarks.at("hip" + side);
  const Vector3d knee = body.landmarks.at("knee" + side).point;
  // the shaft's axis: from the bone's middle below the trochanters to the knee
  const int thigh = part_label("thigh" + side);
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  for (std::size_t n = 0; n < out.hu.size(); ++n) {
    const Vector3d p = body.centre(n);
    if (body.bone[n] && body.owner[n] == thigh && std::abs(hip.point.z() - 100 - p.z()) < 10)
      sum += p, ++count;
  }
  const Vector3d shaft = sum / std::max(count, 1.0), along = (shaft - knee).normalized();
  const Vector3d top = shaft + along * 70;
  for (std::size_t n = 0; n < out.hu.size(); ++n) {
    if (!body.bone[n]) continue;
    const Vector3d p = body.centre(n);
    const bool femur = body.owner[n] == thigh;
    const double from_hip = (p - hip.point).norm();
    const Vector3d down = p - top, neck = top - hip.point;
    const double t = down.dot(along),
                 u = std::clamp((p - hip.point).dot(neck) / neck.squaredNorm(), 0.0, 1.0);
    const bool stem = femur && t < 0 && t > -130 && (down - t * along).norm() < 7;
    const bool head = femur && from_hip < hip.radius + 1;
    const bool cup = body.is(n, 41, 42) && from_hip < hip.radius + 5;
    const bool neck_piece = femur && (p - hip.point - u * neck).norm() < 9;
    if (stem || head || cup || neck_piece)
      out.hu[n] = static_cast<std::int16_t>(tissue::metal.hu), out.density[n] = metal_density;
  }
}

void lose(const LabelledBody& body, const Loss& loss, WarpedTissue& out) {
  const Part& part = parts[static_cast<std::size_t>(loss.part)];
  const std::string side = part.name.ends_with("_left") ? "_left" : "_right";
  const std::string next = part.name.starts_with("thigh")       ? "knee"
                           : part.name.starts_with("shank")     ? "ankle"
                           : part.name.starts_with("upper_arm") ? "elbow"
                                                                : "wrist";
  const Vector3d start = body.landmarks.find(part.joint)->second.point,
                 end = body.landmarks.at(next + side).point;
  const Vector3d along = (end - start).normalized();
  const double at = loss.from * (end - start).norm();
  for (std::size_t n = 0; n < out.hu.size(); ++n) {
    if (!hangs_on(body.owner[n], loss.part)) continue;
    const Vector3d d = body.centre(n) - start;
    const double t = d.dot(along);
    const bool beyond = body.owner[n] != loss.part || loss.from == 0 || t > at;
    if (beyond && loss.artificial && (d - t * along).norm() < 16 && body.owner[n] == loss.part) {
      out.thing[n] = 1, out.bone[n] = 0;
      const bool tube = (d - t * along).norm() > 9;
      out.hu[n] = tube ? static_cast<std::int16_t>(tissue::metal.hu) : std::int16_t(-900);
    } else if (beyond) {
      out.gone[n] = 1;
    } else if (t > at - 25 && (out.bone[n] || t > at - 4)) {
      const bool skin = t > at - 4;
      out.bone[n] = 0;
      out.hu[n] = skin ? skin_hu : muscle_hu, out.density[n] = skin ? skin_density : muscle_density;
    }
  }
}

}  // namespace

bool hangs_on(int part, int on) {
  while (part != 0 && part != on) part = part_label(parts[static_cast<std::size_t>(part)].parent);
  return part == on;
}

WarpedTissue warped_tissue(const LabelledBody& body, const Warp& warp) {
  WarpedTissue out;
  out.hu = body.hu, out.density = body.density, out.bone = body.bone;
  out.gone.assign(out.hu.size(), 0), out.thing.assign(out.hu.size(), 0);
  if (warp.scanner.gut_hu > 0 || warp.scanner.vessel_hu > 0) add_contrast(body, warp.scanner, out);
  if (warp.metal_hip) add_metal_hip(body, warp.metal_hip == 1, out);
  if (warp.loss) lose(body, *warp.loss, out);
  return out;
}

}  // namespace borelli::suite
