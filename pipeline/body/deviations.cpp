#include "pipeline/body/deviations.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>

#include "inertia/entries.hpp"
#include "pipeline/body/isb_frames.hpp"
#include "pipeline/body/recut.hpp"
#include "pipeline/body/segment_frames.hpp"
#include "pipeline/body/segment_rows.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/vocabulary/part_words.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

enum Cause : std::size_t {
  density_curve_cause,
  noise_cause,
  voxels_partial,
  voxel_size_cause,
  planes_cause,
  joints_cause
};
constexpr std::size_t causes = 6;

// Sums of squared differences of every entry, by cause. A variant of the table is one random draw or one
// mode.
class Spread {
 public:
  explicit Spread(const InertiaTable& table) : nominal_(numbers_of(table)) {
    for (const auto& row : nominal_) {
      sums_.emplace_back(row.size());
      together_.emplace_back(row.size());
    }
  }

  void add(Cause cause, const InertiaTable& variant, double weight) {
    const auto numbers = numbers_of(variant);
    for (std::size_t r = 0; r < numbers.size(); ++r)
      for (std::size_t e = 0; e < numbers[r].size(); ++e)
        sums_[r][e][cause] += weight * square(numbers[r][e].value - nominal_[r][e].value);
  }
  // adds the common effect of cut planes and joint centres, which enters the total
  void add_together(const InertiaTable& variant, double weight) {
    const auto numbers = numbers_of(variant);
    for (std::size_t r = 0; r < numbers.size(); ++r)
      for (std::size_t e = 0; e < numbers[r].size(); ++e)
        together_[r][e] += weight * square(numbers[r][e].value - nominal_[r][e].value);
  }

  std::vector<EntryDeviation> of_row(std::size_t r) const {
    std::vector<EntryDeviation> all;
    for (std::size_t e = 0; e < nominal_[r].size(); ++e) {
      if (!std::isfinite(nominal_[r][e].value)) continue;
      EntryDeviation deviation{nominal_[r][e].name, 0, {}};
      double total = together_[r][e];
      for (std::size_t cause = 0; cause < causes; ++cause) {
        deviation.by_cause.push_back(std::sqrt(sums_[r][e][cause]));
        if (cause != planes_cause && cause != joints_cause) total += sums_[r][e][cause];
      }
      deviation.total = std::sqrt(total);
      all.push_back(std::move(deviation));
    }
    return all;
  }

 private:
  static double square(double x) { return std::isfinite(x) ? x * x : 0; }
  static std::vector<std::vector<Entry>> numbers_of(const InertiaTable& table) {
    std::vector<std::vector<Entry>> all;
    for (const InertiaRow& row : table.rows) all.push_back(entries_of(table, row));
    all.push_back(entries_of(table, table.whole));
    return all;
  }
  std::vector<std::vector<Entry>> nominal_;
  std::vector<std::vector<std::array<double, causes>>> sums_;
  std::vector<std::vector<double>> together_;
};

class Deviations {
 public:
  Deviations(InertiaTable& table, const DeviationInputs& in) : table_(table), in_(in), spread_(table) {
    for (const InertiaRow& row : in.rows) {
      // rows follow the order of their labels, without labels that have no name or no voxel
      const auto& names = in.labels.names;
      const auto it = std::find(names.begin(), names.end(), row.part);
      label_.push_back(it == names.end() ? 0 : static_cast<std::size_t>(it - names.begin()));
    }
  }

  void run() {
    const double noise = in_.volume.quantity == Quantity::hu ? estimate_noise(in_.volume, in_.labels) : 0;
    if (in_.volume.quantity == Quantity::hu) vary_curve();
    if (!in_.options.how_sure.empty()) vary_mr();
    if (noise > 0) vary_noise(noise);
    if (in_.sampling == Sampling::averages) vary_partial_volume();
    vary_voxels();
    vary_landmarks();
    table_.causes = {"density_curve", "noise", "partial_volume", "voxel_size", "cut_planes", "joint_centres"};
    for (std::size_t n = 0; n < table_.rows.size(); ++n)
      if (table_.rows[n].completeness != Completeness::absent) table_.rows[n].deviations = spread_.of_row(n);
    if (table_.whole.completeness != Completeness::absent)
      table_.whole.deviations = spread_.of_row(table_.rows.size());
  }

 private:
  using Change = std::function<Inertial(std::size_t row, const Inertial&)>;
  InertiaTable table_of(std::vector<InertiaRow> rows, const Landmarks& landmarks) const {
    return table_of_segments(table_.source, std::move(rows), landmarks, in_.options);
  }
  InertiaTable table_of(std::vector<InertiaRow> rows) const {
    return table_of(std::move(rows), in_.landmarks);
  }
  InertiaTable changed(const Change& change) const {
    std::vector<InertiaRow> rows = in_.rows;
    for (std::size_t n = 0; n < rows.size(); ++n)
      if (rows[n].completeness != Completeness::absent) rows[n].inertial = change(n, rows[n].inertial);
    return table_of(std::move(rows));
  }
  BelowAir below() const { return in_.sampling == Sampling::averages ? BelowAir::straight : BelowAir::hold; }
  GreyWeights weights(const DensityCurve& curve) const {
    return density_weights(in_.volume.quantity, curve, below()).value();
  }
  LabelMoments moments(const LabelMap& labels, const GreyWeights& by) const {
    return label_moments(labels, in_.volume, by, in_.options.threads).value();
  }
  InertiaTable weighed(const LabelMoments& all) const {
    return changed([&](std::size_t n, const Inertial& as_is) {
      const Inertial now = to_inertial(all[label_[n]], in_.labels.grid, in_.sampling);
      return now.mass > 0 ? now : as_is;
    });
  }

  void vary_curve();
  void vary_mr();
  void vary_noise(double noise);
  void vary_partial_volume();
  void vary_voxels();
  void note_borders_without_plane(const PartPlanes& cuts);
  void vary_landmarks();
  void vary_planes_rounded(const Recut& recut, Convention convention);

  InertiaTable& table_;
  const DeviationInputs& in_;
  Spread spread_;
  std::vector<std::size_t> label_;  // label of each of in_.rows
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

void Deviations::vary_curve() {
  const auto& curves = density_curves();
  for (const DensityCurve& other : curves)
    if (other.name != in_.curve.name)
      spread_.add(density_curve_cause, weighed(moments(in_.counted, weights(other))),
                  1 / static_cast<double>(curves.size() - 1));
}

// Perturbs a part at random: its mass by a share, its gravity centre along its axes of extent, each of its
// second moments. `mass`, `centre` and `second` are standard deviations: of the mass's share, of the centre
// over the part's standard deviation of extent, of the second moments' share.
Inertial jolted(const Inertial& part, double mass, double centre, double second,
                const std::function<double()>& draw) {
  Matrix3d C = 0.5 * part.tensor.trace() * Matrix3d::Identity() - part.tensor;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(C / part.mass);
  const Vector3d extent = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
  Inertial now = part;
  const double share = 1 + mass * draw();
  now.mass *= share;
  for (int n = 0; n < 3; ++n) now.centre += centre * draw() * extent[n] * axes.eigenvectors().col(n);
  Matrix3d shake;
  for (int r = 0; r < 3; ++r)
    for (int c = r; c < 3; ++c)
      shake(r, c) = shake(c, r) = second * draw() * part.mass * extent[r] * extent[c] * (r == c ? 1 : 0.5);
  C = share * C + axes.eigenvectors() * shake * axes.eigenvectors().transpose();
  now.tensor = C.trace() * Matrix3d::Identity() - C;
  return now;
}

constexpr int small_draws = 24;

void add_share(Moments& to, const Moments& what, double share) {
  to.weight += share * what.weight, to.first += share * what.first, to.second += share * what.second;
}

// For MR: the density each voxel would gain if the denser of two adjacent tissues filled it, and the voxels
// on both sides of the skin.
struct Borders {
  GreyVolume gain;  // kg/m^3
  LabelMap skin;
};

Borders borders_of(const GreyVolume& density, const LabelMap& labels) {
  Borders borders{{{labels.grid, std::vector<std::int16_t>(labels.voxels.size(), 0)}, density.quantity},
                  {{labels.grid, std::vector<std::uint8_t>(labels.voxels.size(), 0)}, {}}};
  const Grid& g = labels.grid;
  const std::array<std::int64_t, 3> stride{1, g.size[0], g.size[0] * g.size[1]};
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::size_t o = g.offset(i, j, k);
        if (!labels.voxels[o]) continue;
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t c = 0; c < 3; ++c)
          for (const std::int64_t by : {-1, 1}) {
            if (at[c] + by < 0 || at[c] + by >= g.size[c]) continue;
            const auto beside = static_cast<std::size_t>(static_cast<std::int64_t>(o) + by * stride[c]);
            if (!labels.voxels[beside] || density.voxels[beside] <= 0)
              borders.skin.voxels[o] = borders.skin.voxels[beside] = labels.voxels[o];
            else
              borders.gain.voxels[o] =
                  std::max(borders.gain.voxels[o],
                           static_cast<std::int16_t>(density.voxels[beside] - density.voxels[o]));
          }
      }
  return borders;
}

void Deviations::vary_noise(double noise) {
  const GreyWeights by = weights(in_.curve);
  // effect of noise on a bent curve: the mean density about each value, weighted by the noise
  const int reach = std::min(500, static_cast<int>(std::ceil(4 * noise)));
  std::vector<double> bell;
  for (int t = -reach; t <= reach; ++t) bell.push_back(std::exp(-0.5 * t * t / (noise * noise)));
  double sum = 0;
  for (const double b : bell) sum += b;
  GreyWeights smooth = by, slope_squared(by.size(), 0.0);
  for (int g = -1100; g <= 3200; ++g) {
    const auto o = static_cast<std::size_t>(g + 32768);
    double mean = 0;
    for (int t = -reach; t <= reach; ++t)
      mean += bell[static_cast<std::size_t>(t + reach)] / sum *
              by[o + static_cast<std::size_t>(t + reach) - static_cast<std::size_t>(reach)];
    smooth[o] = mean;
    const double slope = 0.5 * (by[o + 1] - by[o - 1]);
    slope_squared[o] = slope * slope;
  }
  spread_.add(noise_cause, weighed(moments(in_.counted, smooth)), 1);
  // random remainder in the sums; noise of neighbouring voxels is taken as independent
  const LabelMoments loud = moments(in_.counted, slope_squared);
  const auto draw = [&] { return normal_(random_); };
  for (int n = 0; n < small_draws; ++n)
    spread_.add(noise_cause, changed([&](std::size_t row, const Inertial& part) {
                  const double all = in_.mass[label_[row]].weight;
                  if (all <= 0) return part;
                  const double share = noise * std::sqrt(loud[label_[row]].weight) / all;
                  return jolted(part, share, share, 1.4 * share, draw);  // a bar: sqrt(9/5)
                }),
                1. / small_draws);
}

// Densities read off an MR. Each tissue class has a deviation common to all parts, and one of each part.
// Borders between classes and at the skin may be shifted by 0.15 of a voxel (bone to fat, through lean by
// brightness, and skin over fat). The figures come from bodies drawn at 4 to 6 mm.
void Deviations::vary_mr() {
  constexpr double shift = 0.15, uneven = 0.6;
  const Grid& grid = in_.labels.grid;
  const auto draw = [&] { return normal_(random_); };
  struct Class {
    const MrDensity& is;
    LabelMoments of;  // each voxel with weight 1 kg/m^3
  };
  std::vector<Class> classes;
  for (const MrDensity& is : in_.options.how_sure) {
    GreyWeights alone(65536, 0.0);
    alone[static_cast<std::size_t>(is.density + 32768)] = 1;
    classes.push_back({is, moments(in_.counted, alone)});
  }
  const auto more_of = [&](const LabelMoments& what, double share) {
    LabelMoments more = in_.mass;
    for (std::size_t label = 1; label < more.size(); ++label) add_share(more[label], what[label], share);
    return more;
  };
  for (const Class& c : classes) spread_.add(density_curve_cause, weighed(more_of(c.of, c.is.shared)), 1);
  for (int n = 0; n < small_draws; ++n) {
    LabelMoments more = in_.mass;
    std::array<double, 256> off{};
    for (const Class& c : classes)
      for (std::size_t label = 1; label < more.size(); ++label) {
        add_share(more[label], c.of[label], c.is.own * draw());
        off[label] = std::hypot(off[label], c.is.own * c.of[label].weight);
      }
    spread_.add(density_curve_cause, changed([&](std::size_t row, const Inertial& as_is) {
                  const std::size_t label = label_[row];
                  const Inertial now = to_inertial(more[label], grid, in_.sampling);
                  if (now.mass <= 0) return as_is;
                  // the density also varies within a part
                  const double share = uneven * off[label] / in_.mass[label].weight;
                  return jolted(now, 0, share, 1.7 * share, draw);
                }),
                1. / small_draws);
  }

  const Borders borders = borders_of(in_.volume, in_.labels);
  GreyWeights as_is(65536), squared(65536);
  for (int value = 0; value < 32768; ++value) {
    as_is[static_cast<std::size_t>(value + 32768)] = value;
    squared[static_cast<std::size_t>(value + 32768)] = static_cast<double>(value) * value;
  }
  const auto of_borders = [&](const GreyWeights& by) {
    return label_moments(in_.labels, borders.gain, by, in_.options.threads).value();
  };
  spread_.add(voxels_partial, weighed(more_of(of_borders(as_is), shift)), 1);
  constexpr double both_sides = 0.5, flesh = 1000;  // kg/m^3
  const LabelMoments skin = label_moments(borders.skin, in_.options.threads).value();
  spread_.add(voxels_partial, weighed(more_of(skin, shift * both_sides * flesh)), 1);
  std::vector<InertiaRow> rows = in_.rows;
  for (std::size_t n = 0; n < rows.size(); ++n)
    rows[n].volume +=
        shift * both_sides * 1e-9 * static_cast<double>(skin[label_[n]].voxels) * grid.voxel_volume();
  spread_.add(voxels_partial, table_of(std::move(rows)), 1);

  for (const Class& c : classes) spread_.add(noise_cause, weighed(more_of(c.of, c.is.noise)), 1);
  // noise assigns mixed voxels to either side
  const LabelMoments loud = of_borders(squared);
  const double flipped = std::min(1.0, in_.options.noise_to_contrast);
  for (int n = 0; n < small_draws; ++n)
    spread_.add(noise_cause, changed([&](std::size_t row, const Inertial& part) {
                  const double all = in_.mass[label_[row]].weight;
                  if (all <= 0) return part;
                  const double share = flipped * std::sqrt(loud[label_[row]].weight) / all;
                  return jolted(part, share, share, 1.4 * share, draw);
                }),
                1. / small_draws);
}

void Deviations::vary_partial_volume() {
  constexpr double part_of_skin = 0.05, blur = 1e-3;  // m
  const LabelMoments bare = moments(in_.labels, weights(in_.curve));
  LabelMoments more = in_.mass;
  for (std::size_t label = 1; label < more.size(); ++label) {
    add_share(more[label], in_.mass[label], part_of_skin);
    add_share(more[label], bare[label], -part_of_skin);
  }
  spread_.add(voxels_partial, weighed(more), 1);
  std::vector<InertiaRow> rows = in_.rows;
  for (std::size_t n = 0; n < rows.size(); ++n)
    rows[n].volume +=
        part_of_skin * 1e-9 * in_.volume_voxels.skin[label_[n]] * in_.labels.grid.voxel_volume();
  spread_.add(voxels_partial, table_of(std::move(rows)), 1);
  spread_.add(voxels_partial, changed([&](std::size_t, const Inertial& part) {
                Inertial now = part;
                now.tensor -= 2 * blur * blur * part.mass * Matrix3d::Identity();
                return now;
              }),
              1);
}

// Relative errors of volume and second moments of voxelised ellipsoids, measured in random poses: c (h /
// L)^2, with L the cube root of the volume and h^2 the product of the voxel's geometric and quadratic mean
// edges. Bodies are not ellipsoids; the factor `rough` accounts for that.
void Deviations::vary_voxels() {
  constexpr double rough = 3;
  const bool points = in_.sampling == Sampling::points;
  const double c_volume = points ? 0.67 : 0.043, c_centre = points ? 0.52 : 0.03,
               c_second = points ? 1.4 : 0.17;
  const Matrix3d& axes = in_.labels.grid.axes;
  const double geometric = std::cbrt(std::abs(axes.determinant())), quadratic = axes.norm() / std::sqrt(3.0);
  const auto draw = [&] { return normal_(random_); };
  for (int n = 0; n < small_draws; ++n) {
    std::vector<InertiaRow> rows = in_.rows;
    for (InertiaRow& row : rows) {
      if (row.completeness == Completeness::absent) continue;
      const double L = 1e3 * std::cbrt(row.volume);
      const double off = rough * geometric * quadratic / (L * L);
      const double extent = std::sqrt(0.5 * row.inertial.tensor.trace() / row.inertial.mass / 3);
      const double mass = row.inertial.mass;
      row.inertial =
          jolted(row.inertial, c_volume * off, c_centre * off * 1e-3 * L / extent, c_second * off, draw);
      row.volume *= row.inertial.mass / mass;
    }
    spread_.add(voxel_size_cause, table_of(std::move(rows)), 1. / small_draws);
  }
}

// Draws landmarks at random; points derived from a landmark move with it.
Landmarks drawn(const Landmarks& landmarks, const std::function<double()>& draw) {
  Landmarks moved = landmarks;
  for (auto& [name, landmark] : moved)
    if (name != "mid_hip")
      for (int c = 0; c < 3; ++c) landmark.point[c] += landmark.deviation * draw();
  const auto l = moved.find("hip_left"), r = moved.find("hip_right"), m = moved.find("mid_hip");
  if (m != moved.end() && l != moved.end() && r != moved.end())
    m->second.point = 0.5 * (l->second.point + r->second.point);
  return moved;
}

void Deviations::note_borders_without_plane(const PartPlanes& cuts) {
  const auto row_of = [&](std::string_view part) {
    const auto row = std::ranges::find(table_.rows, part, &InertiaRow::part);
    return row == table_.rows.end() || row->completeness == Completeness::absent ? nullptr : &*row;
  };
  for (std::size_t label = 1; label < parts.size(); ++label) {
    InertiaRow *const distal = row_of(parts[label].name), *const proximal = row_of(parts[label].parent);
    if (!distal || !proximal || cuts.parts_off(static_cast<int>(label))) continue;
    for (const auto& [row, other] : {std::pair{distal, proximal}, {proximal, distal}})
      row->notes.push_back("standard deviations do not include errors of its border with the " +
                           in_words(other->part) + ": no plane cuts it");
  }
}

void Deviations::vary_landmarks() {
  double largest = 0;
  for (const auto& [name, landmark] : in_.landmarks)
    if (name != "vertex") largest = std::max(largest, landmark.deviation);  // no plane depends on the vertex
  const auto by = convention(in_.options.cuts);
  const bool planes = by && *by != Convention::bone && !in_.landmarks.empty();
  const bool discs = by == Convention::bone && !in_.landmarks.empty();
  for (InertiaRow& row : table_.rows) {
    if (planes || row.completeness == Completeness::absent) continue;
    const bool of_trunk = row.part == "head" || row.part.ends_with("trunk");
    if (discs && of_trunk) continue;
    if (discs)
      row.notes.push_back(
          "standard deviations do not include errors of the surfaces between the bones of a joint");
    else if (!in_.landmarks.empty())
      row.notes.push_back(
          "standard deviations do not include errors of the cuts, because another program made them");
    else if (part_label(row.part) > 0)
      row.notes.push_back(
          "standard deviations do not include errors of the cuts, because no landmarks were given");
  }
  std::optional<Recut> recut;
  if (planes) {
    const PartPlanes cuts(in_.landmarks, *by);
    note_borders_without_plane(cuts);
    recut.emplace(in_.labels, in_.volume, weights(in_.curve), cuts, largest);
    vary_planes_rounded(*recut, *by);
  }
  std::optional<MovedDiscs> moved_discs;
  if (discs) moved_discs.emplace(in_.labels, in_.volume, weights(in_.curve), in_.landmarks);
  if (largest == 0) return;
  constexpr int draws = 40;
  const auto draw = [&] { return normal_(random_); };
  for (int n = 0; n < draws; ++n) {
    const Landmarks moved = drawn(in_.landmarks, draw);
    std::vector<InertiaRow> cut = in_.rows, laid = in_.rows;
    if (planes || discs) {
      const auto gains = planes ? recut->gains(PartPlanes(moved, *by)) : moved_discs->gains(moved);
      for (std::size_t r = 0; r < cut.size(); ++r) {
        if (cut[r].completeness == Completeness::absent || label_[r] >= gains.size()) continue;
        cut[r].inertial = with_gain(cut[r].inertial, gains[label_[r]]);
        cut[r].volume = std::max(0.0, cut[r].volume + gains[label_[r]].volume);
      }
    }
    std::vector<InertiaRow> both = cut;
    for (auto* rows : {&laid, &both})
      for (InertiaRow& row : *rows)
        if (row.frame) {
          row.frame = segment_frame(row.part, moved, row.inertial, in_.options.cuts);
          if (row.frame && in_.options.frames == "isb") lay_isb_frame(*row.frame, row.part, moved);
        }
    spread_.add(planes_cause, table_of(std::move(cut)), 1. / draws);
    spread_.add(joints_cause, table_of(std::move(laid), moved), 1. / draws);
    spread_.add_together(table_of(std::move(both), moved), 1. / draws);
  }
}

// A plane parallel to the grid's layers is rounded to them as a whole, by up to half a layer (standard
// deviation h / sqrt 12). For oblique planes the roundings average out.
void Deviations::vary_planes_rounded(const Recut& recut, Convention by) {
  const Matrix3d& axes = in_.labels.grid.axes;
  constexpr double across = 100;  // mm, half a segment's breadth
  for (int n = 0; n < small_draws; ++n) {
    const auto gains = recut.gains(PartPlanes(in_.landmarks, by, [&](Cut& cut) {
      double rounded = 0;
      for (int c = 0; c < 3; ++c) {
        const double h = axes.col(c).norm(), along = std::abs(cut.normal.dot(axes.col(c))) / h;
        const double layers = across * std::sqrt(std::max(0.0, 1 - along * along)) / h;
        rounded = std::max(rounded, h / std::sqrt(12.0) / (1 + layers));
      }
      cut.point += rounded * normal_(random_) * cut.normal;
    }));
    std::vector<InertiaRow> rows = in_.rows;
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows[r].completeness != Completeness::absent && label_[r] < gains.size()) {
        rows[r].inertial = with_gain(rows[r].inertial, gains[label_[r]]);
        rows[r].volume = std::max(0.0, rows[r].volume + gains[label_[r]].volume);
      }
    spread_.add(voxel_size_cause, table_of(std::move(rows)), 1. / small_draws);
  }
}

}  // namespace

void add_deviations(InertiaTable& table, const DeviationInputs& inputs) { Deviations(table, inputs).run(); }

}  // namespace borelli
