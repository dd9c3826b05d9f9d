#include "tests/suite/body_score.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "pipeline/body/measure.hpp"
#include "segmentation/vocabulary/cuts.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector3d;
using Counts = std::array<std::array<double, parts.size()>, parts.size()>;

constexpr double there_from = 0.05, absent_to = 0.002, invented_from = 20e3;  // shares, mm^3
constexpr double from_end = 45;                                               // mm
constexpr double sure_from = 0.5;

std::string plain(std::string_view name) {
  std::string out(name);
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

std::string stem(std::string_view name) {
  for (const std::string_view side : {"_left", "_right"})
    if (name.ends_with(side)) return std::string(name.substr(0, name.size() - side.size()));
  return std::string(name);
}

std::string other_side(std::string_view name) {
  if (name.ends_with("_left")) return stem(name) + "_right";
  if (name.ends_with("_right")) return stem(name) + "_left";
  return "";
}

// "arm" of a part of an arm, "leg" of one of a leg, else the name itself
std::string limb_of_part_name(std::string_view name) {
  for (const std::string_view part : {"upper_arm", "forearm", "hand"})
    if (name.starts_with(part)) return "arm";
  for (const std::string_view part : {"thigh", "shank", "foot"})
    if (name.starts_with(part)) return "leg";
  return plain(name);
}

bool well_within(const GreyVolume& grey, const Vector3d& point) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d index = grey.grid.index(point + sign * from_end * Vector3d::Unit(axis));
      // air around the body need not be in the scan, so a face ends the body only along k
      const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
      if (k < 0 || k >= grey.grid.size[2]) return false;
      if (grey.grid.holds(i, j, k) && grey.at(i, j, k) <= -2000) return false;
    }
  const Vector3d index = grey.grid.index(point);
  const double margin = 15;
  for (int c = 0; c < 2; ++c)
    if (index[c] * grey.grid.spacing()[c] < margin ||
        (double(grey.grid.size[std::size_t(c)] - 1) - index[c]) * grey.grid.spacing()[c] < margin)
      return false;
  return true;
}

class Scoring {
 public:
  Scoring(const TrueScan& scan, const Segmentation& found) : scan_(scan), found_(found) {}

  BodyScore all() {
    count_voxels();
    for (std::size_t n = 1; n < parts.size(); ++n) part(n);
    joints();
    landmarks();
    cuts();
    masses();
    return std::move(out_);
  }

 private:
  // Whether a low confidence of these parts, or a warning with this name, reports a problem.
  bool told(std::initializer_list<std::size_t> of, std::string_view name) const {
    for (const std::size_t n : of)
      if (n && found_.part[n].coverage != Coverage::absent && found_.part[n].confidence < sure_from)
        return true;
    for (const Warning& warning : found_.warnings) {
      if (warning.severity == Severity::note) continue;
      const std::string words = plain(warning.text);
      const std::string side = name.ends_with("_left") ? "left " : name.ends_with("_right") ? "right " : "";
      for (const std::string& form : {plain(name), side + plain(stem(name)), side + limb_of_part_name(name)})
        if (words.find(form) != std::string::npos) return true;
    }
    return false;
  }
  void miss(const std::string& what, bool silent) {
    out_.missed.push_back({what, silent});
    ++out_.count["bad misses"], out_.count["silent"] += silent;
  }

  void count_voxels() {
    for (auto& row : both_) row.fill(0);
    bone_.fill(0), right_bone_.fill(0);
    declined_ =
        !found_.warnings.empty() && std::all_of(found_.labels.voxels.begin(), found_.labels.voxels.end(),
                                                [](std::uint8_t label) { return label == 0; });
    const bool bones = !scan_.bones.voxels.empty();
    for (std::size_t o = 0; o < scan_.labels.voxels.size(); ++o) {
      const auto e = scan_.labels.voxels[o], m = found_.labels.voxels[o];
      ++both_[e][m];
      if (bones && scan_.bones.voxels[o] && scan_.bones.voxels[o] == e) ++bone_[e], right_bone_[e] += m == e;
    }
  }

  void part(std::size_t n) {
    const std::string name(parts[n].name);
    double mine = 0, exact = 0;
    for (std::size_t m = 0; m < parts.size(); ++m) mine += both_[m][n], exact += both_[n][m];
    const PartTruth& truth = scan_.part[n];
    const double volume = mine * scan_.labels.grid.voxel_volume();
    if (truth.share <= absent_to) {
      const bool invented = volume >= invented_from;
      ++out_.count[invented ? "invented" : "absent rightly"];
      if (invented) miss(fmt::format("invented {} ({:.0f} ml)", name, volume / 1000), !told({n}, name));
      return;
    }
    if (truth.share < there_from || exact == 0) return;
    ++out_.count["there"];
    if (!declined_) out_.dice.push_back(2 * both_[n][n] / (mine + exact));
    if (bone_[n] > 20 && !declined_) out_.own_bone.push_back(right_bone_[n] / bone_[n]);
    if (both_[n][n] >= 0.5 * exact) {
      ++out_.count["found"];
      return;
    }
    const auto other = static_cast<std::size_t>(part_label(other_side(name)));
    std::size_t most = 0;
    for (std::size_t m = 0; m < parts.size(); ++m)
      if (m != n && both_[n][m] > both_[n][most]) most = m;
    if (declined_) {
      ++out_.count["declined"];
      return;
    }
    const std::string kind = other && both_[n][other] > both_[n][n] && most == other ? "swapped"
                             : most == 0                                             ? "vanished"
                                                                                     : "lost";
    ++out_.count[kind];
    miss(fmt::format("{} {}{}", kind, name, kind == "lost" ? fmt::format(" in {}", parts[most].name) : ""),
         !told({n, most}, name));
  }

  void joints() {
    for (std::size_t n = 1; n < parts.size(); ++n) {
      if (parts[n].joint.empty()) continue;
      const std::string joint(parts[n].joint);
      const auto exact = scan_.landmarks.find(joint);
      const auto found = found_.landmarks.find(joint);
      if (exact == scan_.landmarks.end() || !well_within(scan_.grey, exact->second.point)) continue;
      if (found == found_.landmarks.end()) {
        out_.count["joint lost"] += !declined_;
        continue;
      }
      const Vector3d error = found->second.point - exact->second.point;
      const double deviation = std::hypot(found->second.deviation, exact->second.deviation);
      for (int c = 0; c < 3; ++c)
        out_.joint_honesty.push_back(std::abs(error[c]) / std::max(deviation, 1e-6));
      if (error.norm() <= 5 * std::sqrt(3.0) * deviation) continue;
      const auto parent = static_cast<std::size_t>(part_label(parts[n].parent));
      miss(fmt::format("joint {} by {:.0f} mm (stated {:.0f})", joint, error.norm(), found->second.deviation),
           !told({n, parent}, joint));
    }
  }

  void landmarks() {
    for (const auto& [name, exact] : scan_.landmarks) {
      const auto found = found_.landmarks.find(name);
      if (found == found_.landmarks.end() || !well_within(scan_.grey, exact.point)) continue;
      const Vector3d error = found->second.point - exact.point;
      const double deviation = std::hypot(found->second.deviation, exact.deviation);
      out_.landmark[stem(name)].push_back(error.norm());
      for (int c = 0; c < 3; ++c)
        out_.landmark_honesty[stem(name)].push_back(std::abs(error[c]) / std::max(deviation, 1e-6));
    }
  }

  void cuts() {
    const auto exact = cut_planes(scan_.landmarks), found = cut_planes(found_.landmarks);
    for (const Cut& f : found)
      for (const Cut& e : exact) {
        if (e.joint != f.joint || !well_within(scan_.grey, e.point)) continue;
        const std::string bound = bound_of(f.joint, Convention::deleva1996);
        const auto a = found_.landmarks.find(bound), b = scan_.landmarks.find(bound);
        if (a == found_.landmarks.end() || b == scan_.landmarks.end()) continue;
        const double deviation = std::hypot(a->second.deviation, b->second.deviation);
        out_.cut_honesty.push_back(std::abs((f.point - e.point).dot(e.normal)) / std::max(deviation, 1e-6));
      }
  }

  void masses() {
    const auto table = measure(scan_.grey, found_.labels, found_.landmarks, {}, completeness_of(found_.part));
    if (!table) {
      ++out_.count["no table"];
      return;
    }
    for (const InertiaRow& row : table->rows) {
      const auto n = static_cast<std::size_t>(part_label(row.part));
      const PartTruth& truth = scan_.part[n];
      if (n == 0 || truth.share < there_from || row.inertial.mass <= 0) continue;
      const double error = row.inertial.mass / truth.seen.mass - 1;
      out_.mass.push_back(error);
      if (truth.share < 0.98 || truth.stump || row.completeness != Completeness::whole) continue;
      for (const EntryDeviation& d : row.deviations)
        if (d.entry == "mass_kg" && d.total > 0)
          out_.mass_honesty.push_back(std::abs(row.inertial.mass - truth.seen.mass) / d.total);
    }
  }

  const TrueScan& scan_;
  const Segmentation& found_;
  BodyScore out_;
  Counts both_;
  bool declined_ = false;  // no labels, and a warning says so
  std::array<double, parts.size()> bone_, right_bone_;
};

}  // namespace

BodyScore& BodyScore::operator+=(const BodyScore& other) {
  const auto append = [](std::vector<double>& a, const std::vector<double>& b) {
    a.insert(a.end(), b.begin(), b.end());
  };
  scans += other.scans, refused += other.refused, seconds += other.seconds;
  for (const auto& [name, n] : other.count) count[name] += n;
  append(dice, other.dice), append(own_bone, other.own_bone), append(mass, other.mass);
  for (const auto& [name, errors] : other.landmark) append(landmark[name], errors);
  for (const auto& [name, ratios] : other.landmark_honesty) append(landmark_honesty[name], ratios);
  append(joint_honesty, other.joint_honesty), append(cut_honesty, other.cut_honesty);
  append(mass_honesty, other.mass_honesty);
  missed.insert(missed.end(), other.missed.begin(), other.missed.end());
  return *this;
}

BodyScore score_body(const TrueScan& scan, const Forest* forest) {
  const auto begin = std::chrono::steady_clock::now();
  BodyScore out;
  SegmentOptions options;
  options.forest = forest;
  const auto found = segment(scan.grey, options);
  if (found)
    out = Scoring(scan, *found).all();
  else
    out.refused = 1, out.missed.push_back({"refused: " + found.error().message(), false});
  out.scans = 1;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace borelli::suite
