#include "pipeline/body/belonging.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "error/printable.hpp"
#include "pipeline/body/class_fit.hpp"
#include "segmentation/body/body_mask.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double mask_step = 4;  // mm

}  // namespace

std::string name_of_label(const LabelMap& labels, std::size_t label) {
  return label < labels.names.size() && !labels.names[label].empty() ? labels.names[label]
                                                                     : fmt::format("label {}", label);
}

LabelsInAir labels_in_air(const GreyVolume& volume, const LabelMap& labels, int threads) {
  constexpr double mostly_air = -800;  // HU, four fifths of a voxel
  const WorkVolume scan = resampled(volume, mask_step, threads);
  const Mask body = body_mask(scan);
  LabelsInAir air;
  std::array<std::int64_t, 256> voxels{}, outside{};
  const Grid& g = labels.grid;
  const Eigen::Matrix3d to_mask = body.grid.axes.inverse() * g.axes;
  const Vector3d start = body.grid.index(g.origin);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::size_t o = g.offset(i, j, k);
        const auto label = labels.voxels[o];
        if (!label) continue;
        ++voxels[label];
        if (hu_of(volume.voxels[o], volume.quantity) > mostly_air) continue;
        const Vector3d at = start + to_mask * Vector3d(static_cast<double>(i), static_cast<double>(j),
                                                       static_cast<double>(k));
        const auto a = std::lround(at[0]), b = std::lround(at[1]), c = std::lround(at[2]);
        outside[label] += !body.grid.holds(a, b, c) || !body.at(a, b, c);
      }
  std::int64_t all = 0, out = 0;
  for (std::size_t label = 1; label < 256; ++label) {
    all += voxels[label], out += outside[label];
    if (voxels[label])
      air.share[label] = static_cast<double>(outside[label]) / static_cast<double>(voxels[label]);
    if (air.share[label] > doubtful_in_air) air.doubtful.push_back(label);
    if (air.share[label] > wrong_in_air) air.wrong.push_back(label);
  }
  if (all) air.all = static_cast<double>(out) / static_cast<double>(all);
  const LabelMap on_body = labels_on(labels, body.grid, threads);
  std::int64_t visible = 0, bare = 0;
  for (std::size_t o = 0; o < body.voxels.size(); ++o)
    visible += body.voxels[o], bare += body.voxels[o] && !on_body.voxels[o];
  if (visible) air.bare = static_cast<double>(bare) / static_cast<double>(visible);
  return air;
}

std::string in_words(const LabelsInAir& air, const LabelMap& labels) {
  if (air.doubtful.empty()) return "";
  auto worst_first = air.doubtful;
  std::ranges::stable_sort(worst_first, [&](auto a, auto b) { return air.share[a] > air.share[b]; });
  std::vector<std::string> which;
  for (const std::size_t label : worst_first)
    which.push_back(fmt::format("{} {:.0f} %", name_of_label(labels, label), 100 * air.share[label]));
  return fmt::format(
      "the labels do not fit the scan: {:.1f} % of their voxels are air outside the body ({}), and {:.0f} % "
      "of the visible body has no label; check that they belong to this scan and were not moved or turned",
      100 * air.all, name_list(which, 4), 100 * air.bare);
}

std::string doubt_of_classes(const GreyVolume& volume, const ClassLabels& classes, int threads) {
  const ClassFit fit = class_fit(volume, classes, threads);
  if (fit.judged) return in_words(fit);
  LabelMap on_scan = labels_on(classes.labels, volume.grid, threads);
  on_scan.names = classes.labels.names;
  for (auto& label : on_scan.voxels) {
    if (!label) continue;
    const ClassRule& rule = classes.rule(label);
    if (rule.parts == 0 || rule.tissue == ClassTissue::lung || rule.tissue == ClassTissue::air) label = 0;
  }
  return in_words(labels_in_air(volume, on_scan, threads), on_scan);
}

Result<std::string> compare_volumes(const std::array<PartFinding, parts.size()>& findings,
                                    const LabelMap& labels) {
  constexpr double same = 0.01;
  std::array<std::int64_t, 256> voxels{};
  for (const auto label : labels.voxels) ++voxels[label];
  std::size_t compared = 0;
  std::vector<std::string> differ;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    // a map of requested segments has groups instead of parts, or lacks parts
    const auto it = std::ranges::find(labels.names, parts[n].name);
    if (it == labels.names.end()) continue;
    const double expected = findings[n].volume,
                 labelled = static_cast<double>(voxels[static_cast<std::size_t>(it - labels.names.begin())]) *
                            labels.grid.voxel_volume();
    if (expected == 0) continue;  // not in the scan, or not asked for
    ++compared;
    if (std::abs(labelled - expected) > same * std::max(labelled, expected))
      differ.push_back(
          fmt::format("{} {:.2f} litres instead of {:.2f}", parts[n].name, 1e-6 * labelled, 1e-6 * expected));
  }
  if (differ.empty()) return "";
  if (2 * differ.size() > compared)
    return bad_use(
        "findings",
        fmt::format(
            "they belong to another segmentation than the labels: the volumes of {} of {} parts differ ({}); "
            "give the segmentation.json that was written with these labels",
            differ.size(), compared, name_list(differ, 4)));
  return fmt::format(
      "volumes in the labels differ from those in segmentation.json, whose findings were used anyway: {}",
      name_list(differ, 4));
}

std::string compare_sides(const LabelMap& labels) {
  const Grid& g = labels.grid;
  std::array<double, 256> voxels{};
  std::array<Vector3d, 256> sums;
  sums.fill(Vector3d::Zero());
  std::size_t n = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i, ++n)
        if (const auto label = labels.voxels[n]) {
          ++voxels[label];
          sums[label] += Vector3d(double(i), double(j), double(k));
        }
  const auto to_left = [&](const std::string& name) -> std::optional<double> {
    const auto it = std::ranges::find(labels.names, name);
    const auto label = static_cast<std::size_t>(it - labels.names.begin());
    if (it == labels.names.end() || label >= voxels.size() || voxels[label] == 0) return std::nullopt;
    return g.point(sums[label] / voxels[label])[0];
  };
  std::size_t compared = 0;
  std::vector<std::string> exchanged;
  for (const char* stem : {"thigh_", "upper_arm_"}) {
    const std::string one = stem + std::string("left"), other = stem + std::string("right");
    const auto left = to_left(one), right = to_left(other);
    if (!left || !right) continue;
    ++compared;
    if (*left < *right) exchanged.push_back(fmt::format("{} lies to the right of {}", one, other));
  }
  if (exchanged.empty() || exchanged.size() < compared) return "";
  return fmt::format("left and right are swapped, or the header is mirrored or turned by 180 degrees: {}",
                     name_list(exchanged, 4));
}

Result<std::string> compare_centres(const InertiaTable& table, const Landmarks& landmarks) {
  constexpr double reach = 1.1;
  std::size_t compared = 0;
  std::vector<std::string> apart;
  for (const InertiaRow& row : table.rows) {
    const auto part = std::ranges::find(parts, std::string_view(row.part), &Part::name);
    const auto numbers = anatomical_numbers(row);
    if (part == parts.end() || !numbers || numbers->length <= 0) continue;
    const auto joint = landmarks.find(part->joint);
    if (joint == landmarks.end()) continue;
    ++compared;
    const double away = (1e-3 * joint->second.point - row.inertial.centre).norm();
    if (away > reach * numbers->length)
      apart.push_back(fmt::format("{:.2f} m from {} to the centre of {}", away, part->joint, part->name));
  }
  if (apart.empty()) return "";
  const std::string where = fmt::format("for {} of {} parts the gravity centre is far from the joint ({})",
                                        apart.size(), compared, name_list(apart, 4));
  if (3 * apart.size() > compared)
    return bad_use("landmarks", "they belong to another body or pose than the table: " + where);
  return where;
}

Result<std::string> compare_joints(const Landmarks& landmarks, const LabelMap& labels) {
  constexpr double reach = 60;  // mm
  const Grid& g = labels.grid;
  const auto label_of = [&](std::string_view name) {
    const auto it = std::ranges::find(labels.names, name);
    return it == labels.names.end() ? std::size_t{0} : static_cast<std::size_t>(it - labels.names.begin());
  };
  std::array<bool, 256> there{};
  for (const auto label : labels.voxels) there[label] = true;
  std::size_t compared = 0;
  std::vector<std::string> elsewhere;
  for (const Part& part : parts) {
    const auto joint = landmarks.find(part.joint);
    const std::size_t one = label_of(part.name), other = label_of(part.parent);
    if (part.parent.empty() || joint == landmarks.end() || !one || !other || !there[one] || !there[other])
      continue;
    ++compared;
    const double far = reach + 2 * joint->second.deviation;
    const Vector3d middle = g.index(joint->second.point), spacing = g.spacing();
    std::array<std::int64_t, 3> low{}, high{};
    for (int c = 0; c < 3; ++c) {
      // on a sheared grid the box is too small by the shear, which is slight in scans
      const auto s = static_cast<std::size_t>(c);
      low[s] = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(middle[c] - far / spacing[c])));
      high[s] = std::min(g.size[s] - 1, static_cast<std::int64_t>(std::floor(middle[c] + far / spacing[c])));
    }
    bool met_one = false, met_other = false;
    for (std::int64_t k = low[2]; k <= high[2]; ++k)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t i = low[0]; i <= high[0]; ++i) {
          const auto label = labels.at(i, j, k);
          if (label != one && label != other) continue;
          const Vector3d p = g.point(i, j, k);
          if ((p - joint->second.point).norm() > far) continue;
          (label == one ? met_one : met_other) = true;
        }
    if (!met_one || !met_other) elsewhere.emplace_back(part.joint);
  }
  if (elsewhere.empty()) return "";
  const std::string where =
      fmt::format("{} of {} joint centres do not lie where the labels of their two parts meet ({})",
                  elsewhere.size(), compared, name_list(elsewhere, 4));
  if (2 * elsewhere.size() > compared && elsewhere.size() > 1)
    return bad_use("landmarks", "they belong to another body or pose than the labels: " + where);
  return where;
}

}  // namespace borelli
