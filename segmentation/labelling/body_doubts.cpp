#include "segmentation/labelling/body_doubts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "segmentation/files/plausibility.hpp"
#include "segmentation/vocabulary/part_words.hpp"

namespace borelli {
namespace {

// BMI limits of adults and children, kg/m^2. A part's share varies by a factor of 2; a child's head has up to
// 2.5 times an adult's share.
constexpr double thinnest = 12, heaviest = 60, share_varies = 2, childs_head = 2.5;

/// The first clause of a note without its figures in parentheses. Skips the clause of a stump, which is not a
/// doubt.
std::string brief(const std::string& note) {
  std::string clause = note.substr(0, note.find("; "));
  if (clause.starts_with(stump_note) && clause.size() < note.size())
    clause = note.substr(clause.size() + 2, note.find("; ", clause.size() + 2) - clause.size() - 2);
  const auto figures = clause.rfind(" (");
  if (figures != std::string::npos && clause.ends_with(')')) clause.resize(figures);
  return clause;
}

std::string in_plural(std::string_view part) { return part == "foot" ? "feet" : in_words(part) + "s"; }

bool is_unlike(const Landmark& mark) {
  return mark.source.ends_with(unlike_other_side) || mark.source.ends_with(unlike_body);
}

bool is_by_outline(const Landmark& mark) {
  return mark.source.starts_with("bone: middle of the hum") ||
         mark.source.starts_with("bone: middle of the fem") ||
         mark.source.starts_with("bone: middle of the mal");
}

void warn_of_sides(Segmentation& out) {
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const std::string name(parts[n].name);
    if (!name.ends_with("_left")) continue;
    const std::string stem = name.substr(0, name.size() - 5);
    const PartFinding &left = out.part[n],
                      &right = out.part[static_cast<std::size_t>(part_label(stem + "_right"))];
    if (left.coverage != Coverage::whole || right.coverage != Coverage::whole) continue;
    const double ratio = left.volume / right.volume;
    if (ratio < most_side_ratio && ratio > 1 / most_side_ratio) continue;
    out.warnings.push_back(joined_warning(
        WarningKind::sides, Severity::doubt, "left and right differ in volume",
        fmt::format("{} {} %", in_plural(stem), std::lround(100 * (std::max(ratio, 1 / ratio) - 1)))));
  }
}

}  // namespace

std::optional<double> stature_of(const Landmarks& marks) {
  constexpr double stature = 1741;  // mm, of de Leva's men; the lengths below are theirs
  struct Length {
    const char *from, *to;
    double usual;
  };
  constexpr std::array<Length, 4> lengths{{{"hip", "knee", 422.2},
                                           {"knee", "ankle", 434.0},
                                           {"shoulder", "elbow", 281.7},
                                           {"elbow", "wrist", 268.9}}};
  constexpr double least_sure = 0.15;  // deviation of a length, relative to the usual one
  std::vector<double> statures;
  const auto add = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to, double usual) {
    statures.push_back(stature * (to - from).norm() / usual);
  };
  for (const std::string side : {"_left", "_right"})
    for (const Length& length : lengths) {
      const auto from = marks.find(length.from + side), to = marks.find(length.to + side);
      if (from != marks.end() && to != marks.end() &&
          std::hypot(from->second.deviation, to->second.deviation) < least_sure * length.usual)
        add(from->second.point, to->second.point, length.usual);
    }
  const auto hips = marks.find("mid_hip"), left = marks.find("shoulder_left"),
             right = marks.find("shoulder_right");
  if (hips != marks.end() && left != marks.end() && right != marks.end())
    add(hips->second.point, 0.5 * (left->second.point + right->second.point), 515);
  if (statures.size() < 2) return std::nullopt;
  const auto middle = statures.begin() + static_cast<std::ptrdiff_t>(statures.size() / 2);
  std::nth_element(statures.begin(), middle, statures.end());
  return *middle;
}

void doubt_impossible_volumes(Segmentation& out) {
  const auto stature = stature_of(out.landmarks);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartFinding& finding = out.part[n];
    if (finding.volume == 0) continue;
    const std::string_view name = parts[n].name;
    const double litres = 1e-6 * finding.volume, of_heaviest = 1e3 * most_of_part(name);
    std::string side_less = in_words(name.substr(0, std::min(name.find("_left"), name.find("_right"))));
    const std::string article = std::string("aeiou").find(side_less[0]) == std::string::npos ? "a " : "an ";
    if (litres > of_heaviest) {
      finding.doubt(0.1, fmt::format("{:.3g} l is impossible for {}{} ({:.2g} l in a man of 250 kg): check "
                                     "that the air around the body is -1000 HU",
                                     litres, article, side_less, of_heaviest));
      continue;
    }
    if (!stature || finding.coverage != Coverage::whole) continue;
    const double square = 1e-6 * *stature * *stature;
    const double least = share_of_mass(name) / share_varies * thinnest * square,
                 most =
                     share_of_mass(name) * (name == "head" ? childs_head : share_varies) * heaviest * square;
    if (litres >= least && litres <= most) continue;
    finding.doubt(
        0.1, fmt::format("{:.3g} l is impossible for {}{} ({:.2g} to {:.2g} l in bodies of {:.2f} m)", litres,
                         article, side_less, least, most, 1e-3 * *stature));
  }
}

void warn_of_body(Segmentation& out) {
  double volume = 0;
  bool all = true;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (out.absent[n]) all = false;
    if (out.part[n].coverage != Coverage::whole && !out.absent[n]) {
      const bool stump = out.part[n].note.starts_with(stump_note);
      if (!stump) return;
      all = false;
    }
    volume += out.part[n].volume;
  }
  if (auto doubt = doubt_of_body(1e-9 * volume); !doubt.empty()) {
    out.warnings.push_back({WarningKind::body, Severity::fault, std::move(doubt)});
    return;
  }
  constexpr double least = 11, most = 65;  // l/m^2
  const auto stature = stature_of(out.landmarks);
  if (!stature || !all) return;
  const double litres = 1e-6 * volume, square = 1e-6 * *stature * *stature;
  if (litres < least * square || litres > most * square)
    out.warnings.push_back({WarningKind::body, Severity::doubt,
                            fmt::format("{:.3g} l is impossible for a body of {:.2f} m, the height that its "
                                        "joints suggest ({:.2g} to {:.3g} l)",
                                        litres, 1e-3 * *stature, least * square, most * square)});
}

void warn_of_parts(Segmentation& out) {
  doubt_impossible_volumes(out);
  warn_of_body(out);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const PartFinding& finding = out.part[n];
    if (finding.volume == 0 || finding.confidence >= least_confidence) continue;
    Warning warning = joined_warning(
        WarningKind::part, finding.confidence <= 0.1 ? Severity::fault : Severity::doubt,
        "the boundaries of these parts are uncertain", in_words(parts[n].name), brief(finding.note));
    warning.text = "the boundaries of the " + in_words(parts[n].name) + " are uncertain" +
                   (finding.note.empty() ? "" : ": " + finding.note);
    out.warnings.push_back(std::move(warning));
  }
  warn_of_sides(out);
}

void warn_of_joints(const Grid& grid, Segmentation& out) {
  std::set<std::string> bounds;  // joints between a part in view and its parent in view
  for (const Part& part : parts) {
    if (part.joint.empty() || out.part[static_cast<std::size_t>(part_label(part.name))].volume == 0 ||
        out.part[static_cast<std::size_t>(part_label(part.parent))].volume == 0)
      continue;
    bounds.insert(std::string(part.joint));
    bounds.insert(bound_of(part.joint, out.convention));
  }
  double wrists = 0;
  for (const auto& [name, mark] : out.landmarks) {
    const bool far = mark.deviation > most_joint_deviation + 1e-6;
    if (!name.starts_with("asis") && is_unlike(mark)) {
      const std::string by = fmt::format("by {:.0f} mm", mark.deviation);
      Warning warning = joined_warning(
          WarningKind::joint, far ? Severity::doubt : Severity::note,
          mark.source.ends_with(unlike_other_side)
              ? "left and right limbs differ more in length than in any person, so these joints may lie off"
          : name.starts_with("hip")
              ? "the hips lie closer together or farther apart than the iliac spines allow"
              : "limbs have a length that no body of this size has, so these joints may lie off",
          in_words(name) + " " + by);
      warning.text = in_words(name) + fmt::format(" may lie {:.0f} mm off: ", mark.deviation) +
                     (mark.source.ends_with(unlike_other_side)
                          ? "left and right limbs differ more in length than in any person"
                      : name.starts_with("hip")
                          ? "the hips lie closer together or farther apart than the iliac spines allow"
                          : "its limb has a length that no body of this size has");
      out.warnings.push_back(std::move(warning));
      continue;
    }
    // a hand that is cut or incomplete has its own warning
    if (mark.source.starts_with("bone: between radius") &&
        out.part[static_cast<std::size_t>(part_label("hand" + name.substr(5)))].coverage == Coverage::whole)
      wrists = std::max(wrists, mark.deviation);
    if (far && bounds.contains(name)) {
      out.warnings.push_back(joined_warning(WarningKind::joint, Severity::doubt,
                                            "these joints and boundaries may lie far off",
                                            in_words(name) + fmt::format(" by {:.0f} mm", mark.deviation)));
    } else if (is_by_outline(mark)) {
      out.warnings.push_back(joined_warning(WarningKind::joint, Severity::note,
                                            "the scan does not show the round ends of the bones at these "
                                            "joints, so the bones' outlines place them",
                                            in_words(name),
                                            fmt::format("within {:.0f} mm", 2 * mark.deviation)));
    }
  }
  constexpr double usual = 5, uncertain = 7;  // mm
  const double largest = grid.spacing().maxCoeff();
  if (!out.landmarks.empty() && (largest > usual + 1e-3 || wrists > uncertain))
    out.warnings.push_back(
        {WarningKind::joint, Severity::note,
         fmt::format("voxels of {:.1f} mm are large for this body's joints", largest) +
             (wrists > uncertain ? fmt::format(": a wrist may lie up to {:.0f} mm off, and the boundary "
                                               "between forearm and hand with it",
                                               2 * wrists)
                                 : std::string(": joints and the masses beside them are less certain"))});
}

void add_reader_warnings(const std::vector<std::string>& sentences, const Grid& scan, Segmentation& out) {
  const std::string of_size = doubt_of_size(scan);
  for (const std::string& sentence : sentences) {
    const bool doubtful = !of_size.empty() && sentence.ends_with(of_size);
    add_warnings(out.warnings, WarningKind::scan, doubtful ? Severity::doubt : Severity::note, {sentence});
  }
}

}  // namespace borelli
