#include "pipeline/body/measure.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "error/printable.hpp"
#include "inertia/skin.hpp"
#include "pipeline/body/deviations.hpp"
#include "pipeline/body/isb_frames.hpp"
#include "pipeline/body/segment_frames.hpp"
#include "pipeline/body/segment_rows.hpp"
#include "process/memory.hpp"
#include "segmentation/files/plausibility.hpp"
#include "segmentation/labelling/edge_contact.hpp"
#include "segmentation/vocabulary/part_words.hpp"

namespace borelli {
namespace {

// the corners of both grids lie within a hundredth of a voxel of each other
bool agree(const Grid& a, const Grid& b) {
  if (a.size != b.size) return false;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int n = 0; n < 3; ++n)
      index[n] = (corner >> n & 1) ? static_cast<double>(a.size[static_cast<std::size_t>(n)] - 1) : 0;
    if ((b.index(a.point(index)) - index).cwiseAbs().maxCoeff() > 0.01) return false;
  }
  return true;
}

Result<void> check(const GreyVolume& volume, const LabelMap& labels, const MeasureOptions& options) {
  if (!options.sex.empty() && options.sex != "male" && options.sex != "female")
    return bad_use("sex", fmt::format("'{}' is unknown; expected male or female", printable(options.sex)));
  if (!agree(volume.grid, labels.grid))
    return bad_use(
        "labels",
        fmt::format("they must lie on the volume's grid of {} x {} x {} voxels, but "
                    "have {} x {} x {}, other axes or another origin; resample the labels to the volume",
                    volume.grid.size[0], volume.grid.size[1], volume.grid.size[2], labels.grid.size[0],
                    labels.grid.size[1], labels.grid.size[2]));
  if (!options.density_curve.empty() && volume.quantity != Quantity::hu)
    return bad_use("density curve " + options.density_curve,
                   "applies to CT numbers, and the volume contains densities; leave it out");
  // bytes per voxel: labels grown over the skin, labels that the deviations vary, border marks
  return admit_memory("inertia table", "measuring the parts", 4.0 * static_cast<double>(volume.grid.count()));
}

std::string words_for(Sampling sampling, double mixed, bool requested) {
  const std::string share =
      requested ? "as requested"
                : fmt::format("{:.0f} % of the voxels beside the skin are mixed", 100 * mixed);
  return sampling == Sampling::points
             ? fmt::format("points ({}): labelled voxels only, second moments without correction", share)
             : fmt::format("averages ({}): with the skin's mixed voxels, second moments reduced by h^2/12",
                           share);
}

struct Weighed {
  LabelMoments mass, count;       // with densities as weights; with weight 1
  SkinVolumes volume;             // in voxels
  std::optional<LabelMap> grown;  // with the skin's mixed voxels, if those count
  Sampling sampling;
  std::string sampling_in_words;
};

Result<Weighed> weigh(const GreyVolume& volume, const LabelMap& labels, const DensityCurve& curve,
                      const MeasureOptions& options) {
  const auto weights = density_weights(volume.quantity, curve);
  if (!weights) return tl::unexpected(weights.error());
  const auto mixed = mixed_share(labels, volume, *weights);
  if (!mixed) return tl::unexpected(mixed.error());
  Weighed weighed;
  weighed.sampling = options.sampling.value_or(sampling_by(*mixed));
  weighed.sampling_in_words = words_for(weighed.sampling, *mixed, options.sampling.has_value());
  weighed.count = label_moments(labels, options.threads).value();
  if (weighed.sampling == Sampling::points) {
    for (std::size_t label = 1; label < 256; ++label)
      weighed.volume.all[label] = static_cast<double>(weighed.count[label].voxels);
    weighed.mass = label_moments(labels, volume, *weights, options.threads).value();
  } else {
    const auto straight = density_weights(volume.quantity, curve, BelowAir::straight);
    weighed.grown = grow_skin(labels, options.blur_reach);
    weighed.mass = label_moments(*weighed.grown, volume, *straight, options.threads).value();
    weighed.volume =
        volumes_with_skin(labels, volume, *straight, weighed.mass, options.blur_reach, options.threads)
            .value();
  }
  return weighed;
}

// `cut` is called only for parts that `completeness` does not contain
Completeness judge(InertiaRow& row, const PartCompleteness& completeness, const std::function<bool()>& cut) {
  const auto known = completeness.find(row.part);
  const std::string doubt = known == completeness.end() ? "" : known->second.doubt;
  if (known != completeness.end() && known->second.completeness != Completeness::absent) {
    if (!known->second.why.empty()) row.notes.push_back(known->second.why);
    if (!doubt.empty()) row.notes.push_back(doubt);
    return known->second.completeness;
  }
  const bool reaches = cut();
  if (reaches) row.notes.push_back("reaches the edge of the scan");
  if (!doubt.empty()) row.notes.push_back(doubt);
  return reaches ? Completeness::cut : Completeness::whole;
}

}  // namespace

PartCompleteness completeness_of(const std::array<PartFinding, parts.size()>& findings) {
  PartCompleteness completeness;
  for (std::size_t label = 1; label < parts.size(); ++label)
    completeness[std::string(parts[label].name)] = {
        findings[label].coverage == Coverage::whole ? Completeness::whole
        : findings[label].coverage == Coverage::cut ? Completeness::cut
                                                    : Completeness::absent,
        findings[label].note};
  return completeness;
}

void doubt_what_is_air(const LabelsInAir& air, const LabelMap& labels, PartCompleteness& completeness) {
  for (const std::size_t label : air.doubtful) {
    const PartState unknown{Completeness::absent, "", ""};
    PartState& part = completeness.try_emplace(name_of_label(labels, label), unknown).first->second;
    part.doubt = fmt::format("{:.0f} % of its label is air outside the body", 100 * air.share[label]);
    if (std::ranges::find(air.wrong, label) != air.wrong.end()) {
      part.doubt += ": the label does not fit this body";
      part.completeness = Completeness::cut;
    }
  }
}

Result<InertiaTable> measure(const GreyVolume& volume, LabelMap labels, const Landmarks& landmarks,
                             const MeasureOptions& options, const PartCompleteness& completeness) {
  if (auto checked = check(volume, labels, options); !checked) return tl::unexpected(checked.error());
  labels.grid = volume.grid;
  const auto curve = options.density_curve.empty() ? density_curve(default_density_curve)
                                                   : density_curve(options.density_curve);
  if (!curve) return tl::unexpected(curve.error());
  const auto weighed = weigh(volume, labels, *curve, options);
  if (!weighed) return tl::unexpected(weighed.error());

  std::optional<std::array<bool, 256>> cut;
  std::vector<InertiaRow> rows;
  for (std::size_t label = 1; label < 256; ++label) {
    const bool there = weighed->count[label].voxels > 0;
    if (label >= labels.names.size() && !there) continue;
    InertiaRow row;
    row.part = name_of_label(labels, label);
    row.completeness = there ? judge(row, completeness,
                                     [&] {
                                       if (!cut) cut = cut_labels(labels, volume, options.threads);
                                       return (*cut)[label];
                                     })
                             : Completeness::absent;
    if (const auto known = completeness.find(row.part);
        !there && known != completeness.end() && !known->second.why.empty())
      row.notes.push_back(known->second.why);
    row.volume = 1e-9 * weighed->volume.all[label] * labels.grid.voxel_volume();
    row.inertial = to_inertial(weighed->mass[label], labels.grid, weighed->sampling);
    if (there) row.frame = segment_frame(row.part, landmarks, row.inertial, options.cuts);
    if (row.frame) {
      if (options.frames == "isb")
        if (const auto missing = lay_isb_frame(*row.frame, row.part, landmarks); !missing.empty())
          row.notes.push_back("no ISB frame, because a landmark is missing: " + missing);
      const std::string first_note = row.notes.empty() ? "" : row.notes.front();
      for (auto& note : endpoint_notes(*row.frame, row.part, landmarks, first_note))
        row.notes.push_back(note);
    }
    rows.push_back(std::move(row));
  }

  InertiaSource source;
  const bool hu = volume.quantity == Quantity::hu;
  source.quantity = hu ? "CT numbers" : "densities, kg/m^3";
  source.density_curve = hu ? curve->name : "";
  source.density_source = hu ? curve->source : "";
  source.sampling = weighed->sampling_in_words;
  source.sex = options.sex, source.pose = options.pose, source.cuts = options.cuts;
  source.frames =
      std::ranges::any_of(rows,
                          [](const InertiaRow& row) { return row.frame && !row.frame->origin_name.empty(); })
          ? options.frames
          : MeasureOptions{}.frames;
  source.stature_m = options.stature_m;
  for (const Segment& segment : options.segments)
    source.segments += (source.segments.empty() ? "" : ",") + segment.name;
  InertiaTable table = table_of_segments(std::move(source), rows, landmarks, options);
  if (table.whole.completeness == Completeness::absent) return failure("labels", "no voxel is labelled");
  const auto there = [](const InertiaRow& row) { return row.completeness != Completeness::absent; };
  if (std::ranges::none_of(table.rows, there))
    return failure("--segments " + table.source.segments, "none of these segments is in the scan");
  const bool whole = table.whole.completeness == Completeness::whole;
  if (auto doubt = doubt_of_body(table.whole.volume, table.whole.inertial.mass, whole); !doubt.empty()) {
    table.whole.notes.push_back(doubt);
    table.warnings.push_back(std::move(doubt));
  }
  for (InertiaRow& row : table.rows)
    if (auto doubt = doubt_of_part(row.part, row.volume); !doubt.empty()) {
      table.warnings.push_back(in_words(row.part) + " " + doubt);
      row.notes.push_back(std::move(doubt));
    }
  if (!options.deviations) return table;
  add_deviations(table, {std::move(rows), volume, labels, weighed->grown ? *weighed->grown : labels,
                         weighed->mass, weighed->volume, *curve, weighed->sampling, landmarks, options});
  return table;
}

}  // namespace borelli
