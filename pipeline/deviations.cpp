#include "pipeline/deviations.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>

#include "inertia/entries.hpp"
#include "pipeline/isb_frames.hpp"
#include "pipeline/recut.hpp"
#include "pipeline/segment_frames.hpp"
#include "pipeline/segment_rows.hpp"
#include "segmentation/part_planes.hpp"

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

// Sums of squared differences of every entry, by cause; a variant of the table stands for one draw, or one
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
  // of cut planes and joint centres together, which go into the total
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
      // rows stand in the order of their labels, but for labels without a name and without a voxel
      const auto& names = in.labels.names;
      const auto it = std::find(names.begin(), names.end(), row.part);
      label_.push_back(it == names.end() ? 0 : static_cast<std::size_t>(it - names.begin()));
    }
  }

  void run() {
    const double noise = in_.volume.quantity == Quantity::hu ? estimate_noise(in_.volume, in_.labels) : 0;
    if (in_.volume.quantity == Quantity::hu) vary_curve();
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
  void vary_noise(double noise);
  void vary_partial_volume();
  void vary_voxels();
  void vary_landmarks();
  void vary_planes_rounded(const Recut& recut, Convention convention);

  InertiaTable& table_;
  const DeviationInputs& in_;
  Spread spread_;
  std::vector<std::size_t> label_;  // of each of in_.rows
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

// A part's mass moved by an independent share, its gravity centre along its extents, its second moments each.
// `mass`, `centre` and `second` are standard deviations: of the mass's share, of the centre in the part's
// standard deviations of extent, of the second moments' share.
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

void Deviations::vary_noise(double noise) {
  const GreyWeights by = weights(in_.curve);
  // what the noise's width makes of a bent curve: the mean of the densities about each value
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
  // what does not average out; neighbours are taken for independent
  const LabelMoments loud = moments(in_.counted, slope_squared);
  const auto draw = [&] { return normal_(random_); };
  for (int n = 0; n < small_draws; ++n)
    spread_.add(noise_cause, changed([&](std::size_t row, const Inertial& part) {
                  const double all = in_.mass[label_[row]].weight;
                  if (all <= 0) return part;
                  const double share = noise * std::sqrt(loud[label_[row]].weight) / all;
                  return jolted(part, share, share, 1.4 * share, draw);  // of a bar: sqrt(9/5)
                }),
                1. / small_draws);
}

void Deviations::vary_partial_volume() {
  constexpr double part_of_skin = 0.05, blur = 1e-3;  // m
  const LabelMoments bare = moments(in_.labels, weights(in_.curve));
  LabelMoments more = in_.mass;
  for (std::size_t label = 1; label < more.size(); ++label) {
    more[label].weight += part_of_skin * (in_.mass[label].weight - bare[label].weight);
    more[label].first += part_of_skin * (in_.mass[label].first - bare[label].first);
    more[label].second += part_of_skin * (in_.mass[label].second - bare[label].second);
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

// Shares of volume and second moments by which voxelised ellipsoids are off, measured in random poses: c (h /
// L)^2 with L the cube root of the volume and h^2 the product of the voxel's geometric and quadratic mean
// edges. Bodies are no ellipsoids: three times that.
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

// A landmark's draw moves what was found from it.
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

void Deviations::vary_landmarks() {
  double largest = 0;
  for (const auto& [name, landmark] : in_.landmarks) largest = std::max(largest, landmark.deviation);
  const auto by = convention(in_.options.cuts);
  const bool planes = by && *by != Convention::bone && !in_.landmarks.empty();
  const bool discs = by == Convention::bone && !in_.landmarks.empty();
  for (InertiaRow& row : table_.rows) {
    if (planes || row.completeness == Completeness::absent) continue;
    const bool of_trunk = row.part == "head" || row.part.ends_with("trunk");
    if (discs && of_trunk) continue;
    if (discs)
      row.notes.push_back("deviations take the joints' surfaces for exact");
    else if (!in_.landmarks.empty())
      row.notes.push_back("deviations take the cuts for exact: no planes of ours made them");
    else if (part_label(row.part) > 0)
      row.notes.push_back("deviations take the cuts for exact: no landmarks were given");
  }
  std::optional<Recut> recut;
  if (planes) {
    recut.emplace(in_.labels, in_.volume, weights(in_.curve), PartPlanes(in_.landmarks, *by), largest);
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

// A plane along the grid's layers is rounded to them as a whole: by up to half a layer, h / sqrt 12; across
// them the roundings average out.
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

double estimate_noise(const GreyVolume& volume, const LabelMap& labels) {
  std::vector<int> seen;
  const Grid& g = labels.grid;
  const auto rows = static_cast<std::int64_t>(g.size[1] * g.size[2]);
  const std::int64_t skip = std::max<std::int64_t>(1, rows / 20000);
  for (std::int64_t row = 0; row < rows; row += skip) {
    const auto start = static_cast<std::size_t>(row * g.size[0]);
    for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
      const auto o = start + static_cast<std::size_t>(i);
      if (!labels.voxels[o - 1] || !labels.voxels[o] || !labels.voxels[o + 1]) continue;
      seen.push_back(std::abs(volume.voxels[o - 1] - 2 * volume.voxels[o] + volume.voxels[o + 1]));
    }
  }
  // where tissues meet the differences are large: those beyond three deviations are left out, until none is
  double noise = 0;
  for (int round = 0; round < 10; ++round) {
    if (seen.size() < 100) return 0;
    const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
    std::nth_element(seen.begin(), middle, seen.end());
    const double one = *middle / 0.6745;
    noise = one / std::sqrt(6.0);
    if (std::erase_if(seen, [&](int difference) { return difference > 3 * one; }) == 0) break;
  }
  return noise;
}

void add_deviations(InertiaTable& table, const DeviationInputs& inputs) { Deviations(table, inputs).run(); }

}  // namespace borelli
