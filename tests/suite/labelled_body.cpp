#include "tests/suite/labelled_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "segmentation/files/read.hpp"
#include "tests/suite/body_landmarks.hpp"
#include "tests/suite/finer_slices.hpp"

namespace borelli::suite {
namespace {

constexpr int last_organ = 140;  // 141 is skin added to the head

enum Contact : std::uint8_t { open, arm_left, arm_right, leg_left, leg_right, trunk };

// numbers of the organ list: tissue named after the arms
bool of_arm(int organ) {
  return organ == 11 || organ == 59 || organ == 104 || organ == 108 || organ == 118 || organ == 124 ||
         (organ >= 13 && organ <= 23);
}
bool of_leg(int organ) {
  return organ == 12 || organ == 60 || organ == 105 || organ == 109 || organ == 119 || organ == 125 ||
         (organ >= 28 && organ <= 38);
}
bool is_bone(int organ) { return (organ >= 13 && organ <= 56) || organ == 128; }

std::uint8_t label(std::string_view name) { return static_cast<std::uint8_t>(part_label(name)); }

std::uint8_t bone_part(int organ, bool left) {
  const auto sided = [&](std::string_view l, std::string_view r) { return label(left ? l : r); };
  if (organ == 128 || organ == 26 || organ == 27 || organ == 39 || organ == 40 || organ == 47 || organ == 48)
    return label("head");
  if (organ >= 13 && organ <= 18) return sided("upper_arm_left", "upper_arm_right");
  if (organ >= 19 && organ <= 21) return sided("forearm_left", "forearm_right");
  if (organ == 22 || organ == 23) return sided("hand_left", "hand_right");
  if (organ >= 28 && organ <= 33) return sided("thigh_left", "thigh_right");
  if (organ >= 34 && organ <= 36) return sided("shank_left", "shank_right");
  if (organ == 37 || organ == 38) return sided("foot_left", "foot_right");
  if (organ == 41 || organ == 42 || organ == 53 || organ == 54) return label("lower_trunk");
  if (organ == 51 || organ == 52) return label("middle_trunk");
  return label("upper_trunk");
}

double middle_x(const LabelledBody& body) {
  double sum = 0, count = 0;
  for (std::size_t n = 0; n < body.voxel.size(); ++n)
    if (body.is(n, 41, 42)) sum += body.centre(n).x(), ++count;
  return sum / std::max(count, 1.0);
}

// Below the armpit, the names of tissue separate arms from the rest.
void tell_arms(LabelledBody& body, double middle) {
  const std::int64_t plane = body.grid.size[0] * body.grid.size[1];
  std::int64_t armpit = 0;
  for (std::size_t n = 0; n < body.voxel.size(); ++n)
    if (body.is(n, 124, 124)) armpit = std::max<std::int64_t>(armpit, body.voxel[n] / plane);
  body.contact.assign(body.voxel.size(), open);
  for (std::size_t n = 0; n < body.voxel.size(); ++n) {
    if (body.voxel[n] / plane > armpit) continue;
    if (of_arm(body.organ[n]))
      body.contact[n] = body.centre(n).x() > middle ? arm_left : arm_right;
    else
      body.contact[n] = trunk;
  }
}

// The highest slice below which air or skin separates the legs down to the feet.
std::int64_t crotch(const LabelledBody& body, double middle) {
  const Grid& g = body.grid;
  const auto i0 = static_cast<std::int64_t>((middle - 14 - g.origin.x()) / g.axes(0, 0)),
             i1 = static_cast<std::int64_t>((middle + 14 - g.origin.x()) / g.axes(0, 0));
  std::int64_t k = 2;
  for (; k < g.size[2]; ++k) {
    double sum = 0, count = 0;
    bool apart = false;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (const auto n = body.number[g.offset(i, j, k)]; n && of_leg(body.organ[n - 1]))
          sum += double(j), ++count;
    if (count == 0) break;
    const auto j = static_cast<std::int64_t>(sum / count);
    for (std::int64_t i = i0; i <= i1; ++i) {
      const auto n = body.number[g.offset(i, j, k)];
      apart |= n == 0 || body.is(n - 1, 125, 125) || body.is(n - 1, 123, 123);
    }
    if (!apart) break;
  }
  return k - 1;
}

void tell_legs(LabelledBody& body, const std::vector<std::uint8_t>& nearest, std::int64_t crotch_slice) {
  const std::int64_t plane = body.grid.size[0] * body.grid.size[1];
  for (std::size_t n = 0; n < body.voxel.size(); ++n) {
    if (body.contact[n] != trunk || !of_leg(body.organ[n])) continue;
    if (body.voxel[n] / plane > crotch_slice) continue;
    const std::string_view part = parts[nearest[n]].name;
    if (part.ends_with("_left")) body.contact[n] = leg_left;
    if (part.ends_with("_right")) body.contact[n] = leg_right;
  }
}

// Level of the knee's joint line, mm: the least area of bone below the femur's widest level. `lowest`: of the label of
// the femur; `bones`: voxels of femur, tibia and patella on one side.
double joint_line(const LabelledBody& body, const std::vector<std::size_t>& bones, double lowest) {
  struct Level {
    double left = 1e9, right = -1e9, area = 0;
  };
  // of the joint line below the widest level, mm: 24 in the male, 24 to 29 in the female
  constexpr double nearest = 12, farthest = 38;
  std::map<double, Level> levels;
  for (const std::size_t n : bones) {
    const Eigen::Vector3d p = body.centre(n);
    if (std::abs(p.z() - lowest) > 60) continue;
    Level& at = levels[p.z()];
    at.left = std::min(at.left, p.x()), at.right = std::max(at.right, p.x()), ++at.area;
  }
  double widest = 0, wide_at = lowest, least = 1e9, line = lowest;
  for (const auto& [z, level] : levels)
    if (std::abs(z - lowest) < 45 && level.right - level.left > widest)
      widest = level.right - level.left, wide_at = z;
  for (const auto& [z, level] : levels)
    if (wide_at - z > nearest && wide_at - z < farthest && level.area < least) least = level.area, line = z;
  return line;
}

// The organ list cuts femur and tibia apart in one plane, in the female 35 mm above the joint line. Gives the bone between
// them to the femur; the patella stays with the tibia.
void give_condyles(LabelledBody& body, double middle) {
  constexpr int femur = 31, tibia = 34;  // lower half, first of three organ numbers each
  for (const bool left : {true, false}) {
    std::vector<std::size_t> bones;
    double lowest = 1e9, front = 1e9;
    const auto in_femur = [&](std::size_t n) { return body.is(n, femur, femur + 2); };
    for (std::size_t n = 0; n < body.voxel.size(); ++n)
      if (body.is(n, femur, tibia + 2) && (body.centre(n).x() > middle) == left) {
        bones.push_back(n);
        if (in_femur(n)) lowest = std::min(lowest, body.centre(n).z());
      }
    for (const std::size_t n : bones)
      if (in_femur(n) && body.centre(n).z() < lowest + 40) front = std::min(front, body.centre(n).y());
    const double line = joint_line(body, bones, lowest);
    for (const std::size_t n : bones)
      if (!in_femur(n) && body.centre(n).z() > line && body.centre(n).y() >= front)
        body.organ[n] = std::uint8_t(body.organ[n] - tibia + femur);
  }
}

}  // namespace

bool may_touch(std::uint8_t a, std::uint8_t b) {
  if (a == b || a == open || b == open) return true;
  const auto is_arm = [](std::uint8_t c) { return c == arm_left || c == arm_right; };
  if (is_arm(a) || is_arm(b)) return false;
  return a == trunk || b == trunk;
}

std::vector<std::uint8_t> bone_parts(const LabelledBody& body) {
  const double middle = middle_x(body);
  std::vector<std::uint8_t> out(body.voxel.size());
  for (std::size_t n = 0; n < out.size(); ++n)
    if (is_bone(body.organ[n])) out[n] = bone_part(body.organ[n], body.centre(n).x() > middle);
  return out;
}

// Dijkstra's shortest paths over 26 neighbours, in buckets of half a millimetre.
std::vector<float> paths_through(const LabelledBody& body, const std::vector<std::uint8_t>& seed,
                                 float longest, std::vector<std::uint8_t>* nearest) {
  const Grid& g = body.grid;
  struct Step {
    std::int64_t di, dj, dk, offset;
    float length;
  };
  std::vector<Step> steps;
  for (int dk = -1; dk <= 1; ++dk)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di)
        if (di || dj || dk)
          steps.push_back({di, dj, dk, (dk * g.size[1] + dj) * g.size[0] + di,
                           float((g.axes * Eigen::Vector3d(di, dj, dk)).norm())});
  constexpr float width = 0.5F;
  std::vector<float> path_length(body.voxel.size(), no_tissue_path);
  std::vector<std::vector<std::uint32_t>> bucket(1);
  for (std::size_t n = 0; n < path_length.size(); ++n)
    if (seed[n]) path_length[n] = 0, bucket[0].push_back(static_cast<std::uint32_t>(n));
  if (nearest) *nearest = seed;
  for (std::size_t b = 0; b < bucket.size(); ++b) {
    for (std::size_t m = 0; m < bucket[b].size(); ++m) {  // grows during the loop
      const std::uint32_t n = bucket[b][m];
      if (static_cast<std::size_t>(path_length[n] / width) != b) continue;
      const std::int64_t o = body.voxel[n], i = o % g.size[0], j = o / g.size[0] % g.size[1],
                         k = o / (g.size[0] * g.size[1]);
      for (const Step& s : steps) {
        if (!g.holds(i + s.di, j + s.dj, k + s.dk)) continue;
        const std::uint32_t to = body.number[static_cast<std::size_t>(o + s.offset)];
        if (to == 0) continue;
        const float length = path_length[n] + s.length;
        if (length >= path_length[to - 1] || length > longest ||
            !may_touch(body.contact[n], body.contact[to - 1]))
          continue;
        path_length[to - 1] = length;
        if (nearest) (*nearest)[to - 1] = (*nearest)[n];
        const auto in = static_cast<std::size_t>(length / width);
        if (in >= bucket.size()) bucket.resize(in + 1);
        bucket[in].push_back(to - 1);
      }
    }
    std::vector<std::uint32_t>().swap(bucket[b]);
  }
  return path_length;
}

LabelledBody labelled_body(const std::string& name, const Volume<std::int16_t>& organs,
                           const Volume<std::int16_t>& hu, const Volume<std::int16_t>& density) {
  LabelledBody body;
  body.name = name;
  body.grid = organs.grid;
  body.number.assign(body.grid.count(), 0);
  for (std::size_t o = 0; o < body.number.size(); ++o) {
    const int organ = organs.voxels[o];
    if (organ < 1 || organ > last_organ) continue;
    body.voxel.push_back(static_cast<std::uint32_t>(o));
    body.organ.push_back(static_cast<std::uint8_t>(organ));
    body.bone.push_back(is_bone(organ));
    body.hu.push_back(hu.voxels[o]);
    body.density.push_back(density.voxels[o]);
    body.number[o] = static_cast<std::uint32_t>(body.voxel.size());
    body.mass += density.voxels[o] * body.grid.voxel_volume() * 1e-9;
  }
  const double middle = middle_x(body);
  give_condyles(body, middle);
  tell_arms(body, middle);
  const std::vector<std::uint8_t> bones = bone_parts(body);
  std::vector<float> path_length = paths_through(body, bones, no_tissue_path, &body.owner);
  tell_legs(body, body.owner, crotch(body, middle));
  path_length = paths_through(body, bones, no_tissue_path, &body.owner);
  body.off_bone.resize(path_length.size());
  for (std::size_t n = 0; n < path_length.size(); ++n) {
    body.off_bone[n] = static_cast<std::uint8_t>(std::min(path_length[n], 255.0F));
    if (body.owner[n] == 0) body.owner[n] = label("lower_trunk");  // specks that touch nothing
  }
  body.landmarks = find_body_landmarks(body);
  body.lattice = lattice_of(body);
  return body;
}

Result<LabelledBody> read_labelled_body(const std::string& name, const std::string& shared_folder) {
  const std::string capital = name == "am" ? "AM" : "AF";
  const std::string stem = shared_folder + "/volumes/icrp_" + name + "/" + capital;
  if (!std::filesystem::exists(stem + "_labels.nii.gz"))
    return failure(stem + "_labels.nii.gz", "the labelled adult of ICRP 110 is not there");
  const auto organs =
      read_volume(stem + "_labels.nii.gz", {.quantity = FileQuantity::labels, .progress = {}});
  const auto hu = read_volume(stem + "_hu.nii.gz", {.quantity = FileQuantity::hu, .progress = {}});
  const auto density =
      read_volume(stem + "_density_kgm3.nii.gz", {.quantity = FileQuantity::density_kgm3, .progress = {}});
  for (const auto* read : {&organs, &hu, &density})
    if (!*read) return tl::unexpected<Error>(read->error());
  if (!(organs->volume.grid == hu->volume.grid) || !(organs->volume.grid == density->volume.grid))
    return failure(stem, "labels, CT numbers and densities are not on one grid");
  if (!organs->volume.grid.axes.isDiagonal() || organs->volume.grid.axes.diagonal().minCoeff() <= 0)
    return failure(stem, "the grid's axes are not the patient's");

  // grey values of air to dense bone, for the registration; each organ has one CT number and one density
  std::array<float, 256> grey{};
  std::array<std::int16_t, 256> number{}, kgm3{};
  number[0] = -1000;
  Volume<std::int16_t> organ_at = organs->volume;
  for (std::size_t o = 0; o < organ_at.voxels.size(); ++o) {
    if (organ_at.voxels[o] > last_organ) organ_at.voxels[o] = 0;
    const auto organ = static_cast<std::uint8_t>(organ_at.voxels[o]);
    if (organ == 0) continue;
    number[organ] = hu->volume.voxels[o], kgm3[organ] = density->volume.voxels[o];
    grey[organ] = std::clamp((float(number[organ]) + 1000) / 2000, 0.0F, 1.2F);
  }
  constexpr double thickest = 3;  // mm
  const int factor = int(std::ceil(organ_at.grid.axes(2, 2) / thickest));
  const Volume<std::int16_t> finer = finer_slices(organ_at, grey, factor);
  Volume<std::int16_t> finer_hu{finer.grid, finer.voxels}, finer_density = finer_hu;
  for (std::int16_t& voxel : finer_hu.voxels) voxel = number[static_cast<std::uint8_t>(voxel)];
  for (std::int16_t& voxel : finer_density.voxels) voxel = kgm3[static_cast<std::uint8_t>(voxel)];
  return labelled_body(name, finer, finer_hu, finer_density);
}

}  // namespace borelli::suite
