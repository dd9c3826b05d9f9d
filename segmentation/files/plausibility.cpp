#include "segmentation/files/plausibility.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "segmentation/files/display_window.hpp"

namespace borelli {
namespace {

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

constexpr int below_tissue = -200;  // HU: air and lungs lie below

// Compares the values below tissue with those of air, which has -1000 HU by definition and a narrow peak.
// Lungs have -900 to -600, a wide one: a scan within the chest may show nothing else. Errors: most of the
// values below tissue are lower than air, or form a narrow peak above lungs.
Result<void> check_air(const std::string& path, const ValueCounts& counts, std::int64_t too_low,
                       std::vector<std::string>& warnings) {
  constexpr int half_width = 50, highest_air = -900, highest_lung = -600;
  constexpr double enough = 0.05, most = 0.75, hardly_any = 0.01;
  const std::int64_t low = counts.between(padding_hu + 1, below_tissue - 1);
  if (too_low > low / 2 && share(too_low, counts.seen()) > 0.01)
    return failure(path, fmt::format("is not a volume of CT numbers: {} of its voxels below tissue are below "
                                     "-1100, lower than air; check whether the intercept was applied twice "
                                     "(unseen voxels have one value, or NaN)",
                                     percent(share(too_low, low))));
  if (share(low, counts.seen()) < enough) return {};
  int first = 0, last = 0;  // values about which most others lie
  std::int64_t at_peak = 0;
  for (int value = padding_hu + 1; value < below_tissue; ++value) {
    const auto about = counts.between(value - half_width, std::min(value + half_width, below_tissue - 1));
    if (about < at_peak) continue;
    if (about > at_peak) first = value;
    last = value, at_peak = about;
  }
  const int peak = (first + last) / 2;
  if (peak > highest_lung && share(at_peak, low) > most)
    return failure(
        path, fmt::format("is not a volume of CT numbers: {} of its voxels below tissue lie within {} of "
                          "{}, but air has -1000; check slope and intercept",
                          percent(share(at_peak, low)), half_width, peak));
  if (share(counts.between(padding_hu + 1, highest_air), low) < hardly_any)
    warnings.push_back(
        fmt::format("hardly any of the voxels below tissue lie near -1000, where air lies, most "
                    "near {}; check slope and intercept",
                    peak));
  return {};
}

}  // namespace

Result<void> check_values(const std::string& path, const GreyVolume& volume, const ValueCounts& counts,
                          const Clamped& clamped, std::vector<std::string>& warnings) {
  const auto all = static_cast<std::int64_t>(volume.voxels.size()), seen = counts.seen();
  constexpr double few = 0.05;
  if (volume.quantity == Quantity::density_kgm3 && share(clamped.below, all) > few)
    return failure(path,
                   fmt::format("is not a volume of densities: {} of its voxels are below -100 kg/m3; check "
                               "slope and intercept",
                               percent(share(clamped.below, all))));
  if (volume.quantity != Quantity::hu) return {};
  const bool airless = share(counts.between(padding_hu + 1, below_tissue - 1), seen) < 1e-3;
  const double above = share(clamped.above, all);
  double wrapped = above;  // air's -1024 to -900 as unsigned numbers of 12 to 15 bits; 3071 is metal's value
  for (const int bits : {12, 13, 14, 15})
    wrapped += share(counts.between((1 << bits) - 1024, (1 << bits) - 900), all);
  if (airless && wrapped > 0.05)
    return failure(path, fmt::format("is not a volume of CT numbers: its signed numbers were stored as "
                                     "unsigned ({} of its voxels have such values, none is below -200); "
                                     "declare them as signed (PixelRepresentation 1, or a signed voxel type)",
                                     percent(wrapped)));
  // with 1000 or 1024 added, soft tissue lies in the first range, hardly anything beside it, air in the last
  const std::int64_t raised = counts.between(824, 1224), near_zero = counts.between(-76, 124),
                     beside = counts.between(424, 823) + counts.between(1225, INT16_MAX);
  const bool two_peaks = raised > 4 * beside && share(raised, seen) > 0.05 && share(near_zero, seen) > 0.01;
  if (airless && two_peaks)
    return failure(path,
                   fmt::format("is not a volume of CT numbers: {} of its voxels look like soft tissue with "
                               "1000 or 1024 added, {} like such air, and none is below -200; subtract the "
                               "offset, or state it in the header (RescaleIntercept -1024, scl_inter -1024)",
                               percent(share(raised, seen)), percent(share(near_zero, seen))));
  const DisplayWindow window = display_window(counts);
  if (window.low_cut) return failure(path, advice_on(window));
  if (window.high_cut)
    warnings.push_back(
        fmt::format("{} of its voxels have the greatest value, {}: denser bone was cut off there and will "
                    "weigh too little; export the scan without a display window",
                    percent(window.at_greatest), window.greatest));
  if (above > few)
    return failure(path,
                   fmt::format("is not a volume of CT numbers: {} of its voxels are above 32767; check slope "
                               "and voxel type",
                               percent(above)));
  if (auto fine = check_air(path, counts, clamped.below, warnings); !fine) return fine;
  if (airless)
    warnings.push_back(
        "no value is below -200, so the volume shows no air; CT numbers with 1024 added look like that");
  else if (share(counts.between(-200, 200), seen) < 1e-3)
    warnings.push_back(
        "hardly any value lies between -200 and 200, where soft tissue lies; check slope and intercept");
  return {};
}

std::string doubt_of_size(const Grid& grid) {
  const Eigen::Vector3d spacing = grid.spacing();
  if (spacing.minCoeff() < 0.01 || spacing.maxCoeff() > 50)
    return fmt::format(
        "voxels of {:.4g} x {:.4g} x {:.4g} mm are unlikely for a scan of a body; check the unit", spacing[0],
        spacing[1], spacing[2]);
  for (int axis = 0; axis < 3; ++axis)
    if (const double length = spacing[axis] * static_cast<double>(grid.size[static_cast<std::size_t>(axis)]);
        length > longest_scan)
      return fmt::format(
          "{} voxels of {:.4g} mm are {:.3g} m, more than any scanner covers; check the voxel size",
          grid.size[static_cast<std::size_t>(axis)], spacing[axis], 1e-3 * length);
  return "";
}

double share_of_mass(std::string_view part) {
  constexpr std::pair<std::string_view, double> shares[] = {
      {"head", .068},      {"upper_trunk", .157}, {"middle_trunk", .155}, {"lower_trunk", .118},
      {"upper_arm", .026}, {"forearm", .015},     {"hand", .0059},        {"thigh", .145},
      {"shank", .046},     {"foot", .0133}};
  for (const auto& [name, share] : shares)
    if (part.starts_with(name)) return share;
  return std::numeric_limits<double>::infinity();
}

double most_of_part(std::string_view name) {
  constexpr double heaviest = 0.25;  // m^3 at the density of water
  return heaviest * share_of_mass(name);
}

std::string doubt_of_part(std::string_view name, double volume) {
  const double most = most_of_part(name);
  if (volume <= most) return "";
  return fmt::format(
      "is {:.3g} l large; that of a man of 250 kg is {:.2g} l; check the voxel size, and that the air around "
      "the body is -1000 HU",
      1e3 * volume, 1e3 * most);
}

std::string doubt_of_body(double volume, double mass, bool whole) {
  // Newborns weigh 2.5 kg and more; hardly anyone who fits into a scanner's bore weighs over 200 kg. Body
  // density is 0.93 kg/l with full lungs and up to 1.1 kg/l without air in them.
  constexpr double lightest = 2, heaviest = 200, impossible = 300, thinnest = 0.8, densest = 1.25;
  const double weight = mass > 0 ? mass : 1e3 * volume;
  const std::string of = mass > 0 ? fmt::format("{:.3g} kg", mass) : fmt::format("{:.3g} l", 1e3 * volume);
  const std::string excuse = " (A labelled piece of a person may have it)";
  if ((whole && weight < lightest) || weight > impossible)
    return fmt::format("the body has {}, which is impossible for a whole person; check the voxel size{}", of,
                       whole ? excuse : "");
  if (weight > heaviest)
    return fmt::format(
        "the body has {}, more than nearly anyone who fits into a scanner; check the voxel size, and that "
        "nothing else (table, phantom) is labelled",
        of);
  if (!whole) return "";
  const double density = 1e-3 * mass / volume;
  if (mass > 0 && (density < thinnest || density > densest))
    return fmt::format(
        "the body has {:.3g} kg/l, which is impossible for a whole person; check the values, and that the "
        "labels belong to them{}",
        density, excuse);
  return "";
}

}  // namespace borelli
