#include "segmentation/files/plausibility.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <utility>

#include "segmentation/files/display_window.hpp"
#include "threads/clones.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

// block length: counts fit into 16 bits, which a vector register holds the most of
constexpr std::int64_t together = 1 << 15;

BORELLI_VECTOR_CLONES
void find_ends(const std::int16_t* at, std::int64_t count, ValueCounts& counts) {
  std::int16_t least = counts.least, greatest = counts.greatest;
  for (std::int64_t n = 0; n < count; ++n)
    least = std::min(least, at[n]), greatest = std::max(greatest, at[n]);
  counts.least = least, counts.greatest = greatest;
}

BORELLI_VECTOR_CLONES
void count_block(const std::int16_t* at, std::int64_t count, ValueCounts& counts) {
  std::uint16_t unseen = 0, low = 0, soft = 0, zero = 0, raised = 0, beside = 0, wrapped = 0;
  for (std::int64_t n = 0; n < count; ++n) {
    const std::int16_t v = at[n];
    unseen = static_cast<std::uint16_t>(unseen + (v == padding_hu));
    low = static_cast<std::uint16_t>(low + (v < -200));
    soft = static_cast<std::uint16_t>(soft + ((v >= -200) & (v <= 200)));
    zero = static_cast<std::uint16_t>(zero + ((v >= -76) & (v <= 124)));
    raised = static_cast<std::uint16_t>(raised + ((v >= 824) & (v <= 1224)));
    beside = static_cast<std::uint16_t>(beside + (((v >= 424) & (v < 824)) | (v > 1224)));
    // 3072 and above: 12-bit CT numbers end at 3071, the value of metal
    wrapped =
        static_cast<std::uint16_t>(wrapped + (((v >= 3072) & (v <= 3196)) | ((v >= 7168) & (v <= 7292)) |
                                              ((v >= 15360) & (v <= 15484)) | ((v >= 31744) & (v <= 31868))));
  }
  counts.seen += count - unseen, counts.below_tissue += low - unseen;
  counts.soft += soft, counts.near_zero += zero, counts.raised += raised, counts.beside_raised += beside;
  counts.wrapped += wrapped;
}

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

}  // namespace

ValueCounts count_values(const GreyVolume& volume) {
  ValueCounts all;
  all.least = all.greatest = volume.voxels.front();
  std::mutex mutex;
  in_slabs(std::ssize(volume.voxels), 0, [&](std::int64_t first, std::int64_t last) {
    ValueCounts own;
    own.least = own.greatest = volume.voxels.front();
    for (std::int64_t from = first; from < last; from += together) {
      const std::int64_t count = std::min(together, last - from);
      find_ends(volume.voxels.data() + from, count, own);
      if (volume.quantity == Quantity::hu) count_block(volume.voxels.data() + from, count, own);
    }
    const std::lock_guard lock(mutex);
    all.least = std::min(all.least, own.least), all.greatest = std::max(all.greatest, own.greatest);
    all.seen += own.seen, all.below_tissue += own.below_tissue, all.soft += own.soft;
    all.near_zero += own.near_zero, all.raised += own.raised, all.beside_raised += own.beside_raised;
    all.wrapped += own.wrapped;
  });
  return all;
}

Result<void> check_values(const std::string& path, const GreyVolume& volume, const ValueCounts& counts,
                          const Clamped& clamped, std::vector<std::string>& warnings) {
  if (volume.quantity != Quantity::hu) return {};
  const auto all = static_cast<std::int64_t>(volume.voxels.size());
  const bool airless = share(counts.below_tissue, counts.seen) < 1e-3;
  const double above = share(clamped.above, all), below = share(clamped.below, all);
  const double wrapped = above + share(counts.wrapped, all);
  if (airless && wrapped > 0.05)
    return failure(path, fmt::format("is not a volume of CT numbers: its signed numbers were stored as "
                                     "unsigned ({} of its voxels have such values, none is below -200); "
                                     "declare them as signed (PixelRepresentation 1, or a signed voxel type)",
                                     percent(wrapped)));
  const bool two_peaks = counts.raised > 4 * counts.beside_raised &&
                         share(counts.raised, counts.seen) > 0.05 &&
                         share(counts.near_zero, counts.seen) > 0.01;
  if (airless && two_peaks)
    return failure(path,
                   fmt::format("is not a volume of CT numbers: {} of its voxels look like soft tissue with "
                               "1000 or 1024 added, {} like such air, and none is below -200; subtract the "
                               "offset, or state it in the header (RescaleIntercept -1024, scl_inter -1024)",
                               percent(share(counts.raised, counts.seen)),
                               percent(share(counts.near_zero, counts.seen))));
  const DisplayWindow window = display_window(volume);
  if (window.low_cut) return failure(path, advice_on(window));
  if (window.high_cut)
    warnings.push_back(
        fmt::format("{} of its voxels have the greatest value, {}: denser bone was cut off there and will "
                    "weigh too little; export the scan without a display window",
                    percent(window.at_greatest), window.greatest));
  constexpr double few = 0.05;
  if (below + above > few)
    return failure(
        path, fmt::format(
                  "is not a volume of CT numbers: {} of its voxels are {}; {}", percent(below + above),
                  below > above ? "below -1500 with many different values" : "above 32767",
                  below > above
                      ? "check whether the intercept was applied twice (unseen voxels have one value, or NaN)"
                      : "check slope and voxel type"));
  if (airless)
    warnings.push_back(
        "no value is below -200, so the volume shows no air; CT numbers with 1024 added look like that");
  else if (share(counts.soft, counts.seen) < 1e-3)
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
