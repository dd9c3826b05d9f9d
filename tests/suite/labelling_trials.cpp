// labelling_trials: scores of the voxel labeller, as tables.
//   labelling_trials [--model FILE] [--pieces] [--joints] [--whole-only] [--phantoms FIRST LAST] [FOLDER ...]
// Bodies: folders with scan.nii.gz and parts.nii.gz, and phantoms by seed. Each is tried whole, mirrored,
// without a leg, without an arm, and in parts of its height and breadth. Without --model: the program's own
// forest.
#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "segmentation/volume/held_memory.hpp"
#include "tests/suite/labelling_score.hpp"

namespace {

using namespace borelli;

struct Asked {
  std::string model;
  bool pieces = false, joints = false, whole_only = false;
  std::uint64_t first_phantom = 1, last_phantom = 0;
  std::vector<std::string> folders;
};

bool parse(int count, char** words, Asked& asked) {
  for (int n = 1; n < count; ++n) {
    const std::string_view word = words[n];
    if (word == "--model" && n + 1 < count) {
      asked.model = words[++n];
    } else if (word == "--pieces") {
      asked.pieces = true;
    } else if (word == "--joints") {
      asked.joints = true;
    } else if (word == "--whole-only") {
      asked.whole_only = true;
    } else if (word == "--phantoms" && n + 2 < count) {
      asked.first_phantom = std::strtoull(words[++n], nullptr, 10);
      asked.last_phantom = std::strtoull(words[++n], nullptr, 10);
    } else if (word.starts_with("--")) {
      return false;
    } else {
      asked.folders.emplace_back(word);
    }
  }
  return true;
}

class Tables {
 public:
  Tables(const Asked& asked, const Forest& forest) : asked_(asked), forest_(forest) {
    fmt::print("{:34s} voxels  right region piece |", "");
    for (const auto name : suite::limb_names) fmt::print(" {:>9s}", name);
    fmt::print(" |");
    for (std::size_t c = 2; c < voxel_class_count; ++c) fmt::print(" {:>9s}", voxel_classes[c]);
    fmt::print(" | wall s, processor s\n");
  }

  void add(const std::string& name, const suite::LabelledScan& scan) {
    const auto score = suite::score_labelling(scan, forest_);
    const auto dice = [](double value) {
      return value < 0 ? std::string("-") : fmt::format("{:.3f}", value);
    };
    fmt::print("{:34s} {:6.0f}  {:.3f}  {:.3f}  {:.3f} |", name, score.voxels, score.right,
               score.right_region, score.right_piece);
    for (const double value : score.limb_dice) fmt::print(" {:>9s}", dice(value));
    fmt::print(" |");
    for (std::size_t c = 2; c < voxel_class_count; ++c) fmt::print(" {:>9s}", dice(score.class_dice[c]));
    fmt::print(" | {:.2f} {:.2f}\n", score.seconds, score.processor_seconds);
    for (std::size_t n = 0; n < suite::Calibration::bins; ++n) {
      calibration_.voxels[n] += score.calibration.voxels[n];
      calibration_.right[n] += score.calibration.right[n];
    }
    for (const auto& joint : score.joints) add_joint(joint);
    for (std::size_t p = 0; asked_.pieces && p < score.pieces.list.size(); ++p) print_piece(score, p);
    for (const auto& joint : score.joints)
      if (asked_.joints)
        fmt::print("    {:12s} off by {:6.1f} {:6.1f} {:6.1f} mm, states {:.1f}\n", joint.name,
                   joint.error[0], joint.error[1], joint.error[2], joint.deviation);
    std::fflush(stdout);
  }

  void print_sums() const {
    fmt::print("\nmost probable region: probability, share of the voxels, share right\n");
    double all = 0;
    for (const double n : calibration_.voxels) all += n;
    for (std::size_t n = 0; n < suite::Calibration::bins; ++n)
      if (calibration_.voxels[n] > 0)
        fmt::print("  {:.1f} to {:.1f}   {:.3f}   {:.3f}\n", 0.2 + 0.1 * static_cast<double>(n),
                   0.3 + 0.1 * static_cast<double>(n), calibration_.voxels[n] / all,
                   calibration_.right[n] / calibration_.voxels[n]);
    fmt::print(
        "\njoints: count, root mean square error of a coordinate (mm), share of coordinates within 2 stated "
        "deviations\n");
    for (const auto& [name, sum] : joints_)
      fmt::print("  {:6s} {:4.0f} {:6.1f} {:6.2f}\n", name, sum.count,
                 std::sqrt(sum.squares / (3 * sum.count)), sum.within / (3 * sum.count));
  }

 private:
  struct JointSum {
    double count = 0, squares = 0, within = 0;
  };

  void add_joint(const suite::LabellingScore::Joint& joint) {
    JointSum& sum = joints_[joint.name.substr(0, joint.name.find('_'))];
    ++sum.count, sum.squares += joint.error.squaredNorm();
    for (int c = 0; c < 3; ++c) sum.within += std::abs(joint.error[c]) <= 2 * joint.deviation;
  }

  static void print_piece(const suite::LabellingScore& score, std::size_t p) {
    const BodyPiece& piece = score.pieces.list[p];
    const Eigen::Vector3d root = piece.root.value_or(Eigen::Vector3d::Zero());
    fmt::print(
        "    {:5s} {:5s} {:6.2f} l, bone chain {:4.0f} mm, root {:5.0f} {:5.0f} {:5.0f} of {:4.0f} cm2{}, "
        "confidence {:.3f}, right {:.3f}\n",
        body_region_names[static_cast<std::size_t>(piece.region)],
        piece.side < 0 ? "" : side_suffix(piece.side) + 1, piece.volume / 1e6, piece.bone_chain, root[0],
        root[1], root[2], piece.root_area / 100, piece.cut ? ", cut" : "", piece.confidence,
        score.piece_right[p]);
  }

  const Asked& asked_;
  const Forest& forest_;
  suite::Calibration calibration_;
  std::map<std::string, JointSum> joints_;
};

int axis_along(const Grid& grid, int row) {
  int axis = 0;
  grid.axes.row(row).cwiseAbs().maxCoeff(&axis);
  return axis;
}

// shares are counted from the feet and from the patient's right
suite::LabelledScan part_of_scan(const suite::LabelledScan& whole, int row, double first, double last) {
  const int axis = axis_along(whole.grey.grid, row);
  const bool reversed = whole.grey.grid.axes(row, axis) < 0;
  return suite::cropped(whole, axis, reversed ? 1 - last : first, reversed ? 1 - first : last);
}

void try_body(const std::string& name, const suite::LabelledScan& whole, const Asked& asked, Tables& tables) {
  tables.add(name, whole);
  if (asked.whole_only) return;
  tables.add("  mirrored", suite::mirrored(whole));
  tables.add("  without the left leg", suite::without_limb(whole, BodyRegion::leg, left_side));
  tables.add("  without the right arm", suite::without_limb(whole, BodyRegion::arm, right_side));
  tables.add("  upper half", part_of_scan(whole, 2, 0.5, 1));
  tables.add("  legs alone", part_of_scan(whole, 2, 0, 0.42));
  tables.add("  chest", part_of_scan(whole, 2, 0.62, 0.85));
  tables.add("  belly and thighs", part_of_scan(whole, 2, 0.3, 0.65));
  tables.add("  head alone", part_of_scan(whole, 2, 0.88, 1));
  tables.add("  left half", part_of_scan(whole, 0, 0.5, 1));
  tables.add("  left leg alone", part_of_scan(part_of_scan(whole, 2, 0, 0.42), 0, 0.5, 1));
}

}  // namespace

int main(int count, char** words) {
  borelli::hold_freed_memory();
  Asked asked;
  if (!parse(count, words, asked)) {
    fmt::print(stderr,
               "labelling_trials [--model FILE] [--pieces] [--joints] [--whole-only] [--phantoms FIRST LAST] "
               "[FOLDER ...]\n");
    return 2;
  }
  const auto forest = asked.model.empty() ? ready_forest() : read_forest(asked.model);
  if (!forest) {
    fmt::print(stderr, "{}\n", forest.error().message());
    return 1;
  }
  try {
    fmt::print("{} trees, {} nodes\n", forest->trees(), forest->nodes());
    Tables tables(asked, *forest);
    for (const std::string& folder : asked.folders) {
      const auto scan = suite::read_labelled(folder);
      if (!scan) throw std::runtime_error(scan.error().message());
      try_body(folder, *scan, asked, tables);
    }
    for (std::uint64_t seed = asked.first_phantom; seed <= asked.last_phantom; ++seed)
      try_body(fmt::format("phantom {}", seed), suite::drawn_phantom(seed), asked, tables);
    tables.print_sums();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
