#include "segmentation/labelling/class_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "segmentation/joints/spheres.hpp"
#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/part_words.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// number of steps between two parts in the body's tree
int steps_between(int a, int b) {
  const auto up = [](int label) { return part_label(parts[static_cast<std::size_t>(label)].parent); };
  int steps = 0;
  for (int from = a; from; from = up(from), ++steps) {
    int more = 0;
    for (int to = b; to; to = up(to), ++more)
      if (to == from) return steps + more;
  }
  return 100;
}

// signed distance to the left of the body's midline, mm
double side_of(const Landmarks& landmarks, const Anatomy& a, const Vector3d& point) {
  for (const char* joint : {"hip", "shoulder"}) {
    const auto l = landmarks.find(std::string(joint) + "_left"),
               r = landmarks.find(std::string(joint) + "_right");
    if (l != landmarks.end() && r != landmarks.end())
      return (point - 0.5 * (l->second.point + r->second.point)).dot(trunk_axes(landmarks).col(0));
  }
  return point[0] - a.grid().point(0.5 * Vector3d(static_cast<double>(a.grid().size[0] - 1), 0, 0))[0];
}

// the contact region of the bones of two parts
struct ClassContact {
  std::vector<Vector3d> surface;       // of the distal bone, within `reach` of the other
  Vector3d middle = Vector3d::Zero();  // half way between the two bones
};

// `counts`: whether a voxel of either bone is considered
template <class IsOther, class Counts>
ClassContact contact_of(const Anatomy& a, const Volume<std::uint8_t>& seeds, int distal, const IsOther& other,
                        const Counts& counts, double reach) {
  ClassContact out;
  const auto& g = a.grid();
  const auto n = static_cast<std::int64_t>(std::ceil(reach / a.step()));
  double pairs = 0;
  const auto is_distal = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return g.holds(i, j, k) && seeds.at(i, j, k) == distal && a.bone.at(i, j, k) && counts(g.offset(i, j, k));
  };
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!is_distal(i, j, k)) continue;
        if (is_distal(i - 1, j, k) && is_distal(i + 1, j, k) && is_distal(i, j - 1, k) &&
            is_distal(i, j + 1, k) && is_distal(i, j, k - 1) && is_distal(i, j, k + 1))
          continue;
        const Vector3d here = g.point(i, j, k);
        bool near = false;
        for (std::int64_t c = -n; c <= n; ++c)
          for (std::int64_t b = -n; b <= n; ++b)
            for (std::int64_t d = -n; d <= n; ++d) {
              if (!g.holds(i + d, j + b, k + c) || !a.bone.at(i + d, j + b, k + c)) continue;
              if (!other(seeds.at(i + d, j + b, k + c)) || !counts(g.offset(i + d, j + b, k + c))) continue;
              const Vector3d there = g.point(i + d, j + b, k + c);
              if ((there - here).norm() > reach) continue;
              near = true;
              out.middle += 0.5 * (here + there);
              ++pairs;
            }
        if (near) out.surface.push_back(here);
      }
  if (pairs > 0) out.middle /= pairs;
  return out;
}

// sphere through the surface points of a head that face the socket, refined in the scan if it shows the head
std::optional<Landmark> head_of(const Anatomy& a, const std::vector<Vector3d>& surface,
                                const std::string& bone) {
  constexpr double least = 15, most = 36;
  if (surface.size() < 12) return std::nullopt;
  const auto rough = sphere_through(surface);
  if (!rough || rough->radius < least - 4 || rough->radius > most + 6) return std::nullopt;
  std::optional<FoundSphere> best;
  for (const FoundSphere& ball : fit_balls(*a.source, rough->centre, least, most, a.threads))
    if ((ball.centre - rough->centre).norm() < 10 && (!best || ball.score > best->score)) best = ball;
  if (best)
    return Landmark{best->centre, std::max(2.0, 2 * best->deviation), best->radius,
                    "bone: sphere on the head of the labelled " + bone};
  // voxel centres lie half a step below the surface
  return Landmark{rough->centre, std::max(4.0, a.step()), rough->radius + a.step() / 2,
                  "labels: sphere through the head of the " + bone};
}

}  // namespace

int nearest_part(PartSet set, int part, double side) {
  int best = 0, nearest = 1000;
  for (int label = 1; label < static_cast<int>(parts.size()); ++label) {
    if (!(set & part_bit(label))) continue;
    const std::string_view name = parts[static_cast<std::size_t>(label)].name;
    const bool other_side = (name.ends_with("_left") && side < 0) || (name.ends_with("_right") && side > 0);
    const int steps = 2 * steps_between(label, part) + (other_side ? 1 : 0);
    if (steps < nearest) nearest = steps, best = label;
  }
  return best;
}

ClassParts::ClassParts(const ClassLabels& map, const Grid& scan, const Grid& work, int threads)
    : map_(map),
      resampled_(same_grid(scan, map.labels.grid) ? LabelMap{} : labels_on(map.labels, scan, threads)),
      scan_(resampled_.voxels.empty() ? map.labels : resampled_),
      work_(labels_on(map.labels, work, threads)) {}

const ClassRule* ClassParts::rule(const LabelMap& labels, std::size_t offset) const {
  const std::uint8_t label = labels.voxels[offset];
  return label ? &map_.rule(label) : nullptr;
}

void ClassParts::mend(Anatomy& a, int threads) const {
  for (std::size_t o = 0; o < work_.voxels.size(); ++o)
    if (const ClassRule* r = rule(work_, o)) {
      a.body.voxels[o] = r->parts != 0;
      // a class without a tissue says nothing about bone
      if (r->parts == 0)
        a.bone.voxels[o] = 0;
      else if (r->tissue != ClassTissue::any)
        a.bone.voxels[o] = r->tissue == ClassTissue::bone;
    }
  measure_depths(a, threads);
}

Volume<std::uint8_t> ClassParts::seeds(const Anatomy& a, const Volume<std::uint8_t>& found,
                                       const PartPlanes& planes, const Landmarks& landmarks) const {
  const auto& g = a.grid();
  Volume<std::uint8_t> out{g, std::vector<std::uint8_t>(g.count(), 0)};
  Mask labelled_bone{g, std::vector<std::uint8_t>(g.count(), 0)};
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::size_t o = g.offset(i, j, k);
        const ClassRule* r = rule(work_, o);
        if (!r || r->parts == 0 || !a.body.voxels[o]) continue;
        const bool bone = r->tissue == ClassTissue::bone, one = std::has_single_bit(r->parts);
        if (!bone && !one) continue;
        const Vector3d p = g.point(i, j, k);
        const int guess = found.voxels[o] ? found.voxels[o] : planes.axial_part(p);
        out.voxels[o] = static_cast<std::uint8_t>(
            one ? std::countr_zero(r->parts) : nearest_part(r->parts, guess, side_of(landmarks, a, p)));
        labelled_bone.voxels[o] = bone;
      }
  // bones without a class, except the rims of those that have one
  const auto off = distance_to(labelled_bone, 12);
  for (std::size_t o = 0; o < out.voxels.size(); ++o)
    if (!out.voxels[o] && a.bone.voxels[o] && off[o] >= 12) out.voxels[o] = found.voxels[o];
  return out;
}

void ClassParts::find_joints(const Anatomy& a, const Volume<std::uint8_t>& seeds, Landmarks& marks,
                             std::vector<std::string>& warnings) const {
  for (int distal = 1; distal < static_cast<int>(parts.size()); ++distal) {
    const Part& part = parts[static_cast<std::size_t>(distal)];
    const std::string joint(part.joint);
    if (joint.empty() || joint.starts_with("spine")) continue;
    const int proximal = part_label(part.parent);
    const bool head = joint.starts_with("hip") || joint.starts_with("shoulder");
    const auto meets = [&](int label) {
      return is_axial(proximal) ? is_axial(label) && label != distal : label == proximal;
    };
    // labelled bones override a joint found in the scan; bones found in the scan itself do not
    const auto there = marks.find(joint);
    const auto counts = [&](std::size_t o) {
      const ClassRule* r = there == marks.end() ? nullptr : rule(work_, o);
      return there == marks.end() || (r && r->parts != 0);
    };
    // the gap between a joint's bones is 3 mm (hip) to 15 mm (wrist, with thick slices)
    ClassContact contact;
    for (const double reach : head ? std::vector{12.} : std::vector{6., 9., 12., 18.})
      if (contact.surface.size() < 6) contact = contact_of(a, seeds, distal, meets, counts, reach);
    if (contact.surface.size() < 6) continue;
    std::optional<Landmark> by_labels;
    if (head)
      by_labels = head_of(a, contact.surface, joint.starts_with("hip") ? "femur" : "humerus");
    else
      by_labels = Landmark{contact.middle, 10, 0, "labels: where the bones meet"};
    if (!by_labels) continue;
    if (there != marks.end()) {
      const double apart = (there->second.point - by_labels->point).norm();
      if (apart < (head ? 15 : 40)) continue;
      warnings.push_back(in_words(joint) + ": the scan shows it " + std::to_string(std::lround(apart)) +
                         " mm from where the labelled bones meet; the labels were used");
      const std::string side =
          joint.substr(joint.rfind('_') == std::string::npos ? joint.size() : joint.rfind('_'));
      const std::string stem = joint.substr(0, joint.size() - side.size());
      marks.erase(stem + "_medial" + side);
      marks.erase(stem + "_lateral" + side);
    }
    marks[joint] = *by_labels;
  }
  const auto l = marks.find("hip_left"), r = marks.find("hip_right");
  if (l != marks.end() && r != marks.end())
    marks["mid_hip"] = {0.5 * (l->second.point + r->second.point),
                        std::max(l->second.deviation, r->second.deviation), 0, "middle of the hip centres"};
}

ClassParts::Place ClassParts::place(std::size_t offset) const {
  const ClassRule* r = rule(scan_, offset);
  return !r ? Place::open : r->parts ? Place::body : Place::outside;
}

int ClassParts::part(std::size_t offset, int owner, const Vector3d& point, const PartPlanes& planes) const {
  const PartSet set = rule(scan_, offset)->parts;
  if (std::has_single_bit(set)) return std::countr_zero(set);
  const int by_planes = owner ? planes.part(owner, point) : planes.axial_part(point);
  if (set & part_bit(by_planes)) return by_planes;
  if (owner && (set & part_bit(owner))) return owner;
  return nearest_part(set, by_planes, planes.side(point));
}

std::vector<std::string> ClassParts::warnings() const {
  double left = 0, right = 0, lefts = 0, rights = 0;
  const auto& g = work_.grid;
  for (std::size_t o = 0; o < work_.voxels.size(); ++o) {
    const ClassRule* r = rule(work_, o);
    if (!r || !std::has_single_bit(r->parts)) continue;
    const std::string_view name = parts[static_cast<std::size_t>(std::countr_zero(r->parts))].name;
    const double x =
        g.origin[0] + g.axes(0, 0) * static_cast<double>(o % static_cast<std::size_t>(g.size[0]));
    if (name.ends_with("_left")) left += x, ++lefts;
    if (name.ends_with("_right")) right += x, ++rights;
  }
  if (lefts == 0 || rights == 0 || left / lefts > right / rights) return {};
  return {
      "the left classes lie on the patient's right; check whether the label map is mirrored, or the scan's "
      "orientation wrong"};
}

}  // namespace borelli
