#include "pipeline/body/segment_frames.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <array>
#include <string>

#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/part_words.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Endpoint {
  std::string_view name;      // de Leva's
  std::string_view landmark;  // ours, without the side
};
using Endpoints = std::array<Endpoint, 2>;

constexpr Endpoint vertex{"VERT", "vertex"}, cervicale{"CERV", "cervicale"},
    suprasternale{"SUPR", "suprasternale"}, xiphion{"XYPH", "xiphion"}, omphalion{"OMPH", "omphalion"},
    mid_hip{"MIDH", "mid_hip"}, shoulder{"SJC", "shoulder"}, elbow{"EJC", "elbow"}, wrist{"WJC", "wrist"},
    knuckle{"MET3", "metacarpale_3"}, hip{"HJC", "hip"}, knee{"KJC", "knee"}, ankle{"AJC", "ankle"},
    malleolus{"LMAL", "lateral_malleolus"}, heel{"HEEL", "heel"}, toe_tip{"TTIP", "toe_tip"}, nowhere{"", ""};

struct SegmentPlan {
  std::string_view segment;
  std::array<Endpoints, 2> endpoints;  // the first pair whose points exist
  Endpoints y;  // Y from the first to the second; for the trunk empty, for a foot its X
  std::array<std::string_view, 2> line;  // pairs of landmarks for X, by name without _lateral and so on
  std::string_view cuts;
};

constexpr std::array<SegmentPlan, 13> plans{{
    {"head", {{{vertex, cervicale}, {vertex, cervicale}}}, {{{"", "neck"}, vertex}}, {}, "zatsiorsky"},
    {"upper_trunk", {{{suprasternale, xiphion}, {cervicale, xiphion}}}, {}, {}, "zatsiorsky"},
    {"middle_trunk", {{{xiphion, omphalion}, {xiphion, omphalion}}}, {}, {}, "zatsiorsky"},
    {"lower_trunk", {{{omphalion, mid_hip}, {omphalion, mid_hip}}}, {}, {}, "zatsiorsky"},
    {"upper_arm", {{{shoulder, elbow}, {shoulder, elbow}}}, {elbow, shoulder}, {"elbow", ""}, "zatsiorsky"},
    {"forearm", {{{elbow, wrist}, {elbow, wrist}}}, {wrist, elbow}, {"elbow", ""}, "joint"},
    {"hand", {{{wrist, knuckle}, {wrist, knuckle}}}, {knuckle, wrist}, {}, "joint"},
    {"thigh", {{{hip, knee}, {hip, knee}}}, {knee, hip}, {"knee", ""}, "zatsiorsky"},
    {"shank", {{{knee, ankle}, {knee, malleolus}}}, {ankle, knee}, {"malleolus", "knee"}, "joint"},
    {"foot", {{{heel, toe_tip}, {heel, toe_tip}}}, {heel, toe_tip}, {}, "joint"},
    // groups of segments.hpp; a limb may be bent and so has no length
    {"trunk", {{{suprasternale, mid_hip}, {cervicale, mid_hip}}}, {}, {}, "zatsiorsky"},
    {"arm", {{{nowhere, nowhere}, {nowhere, nowhere}}}, {elbow, shoulder}, {"elbow", ""}, "zatsiorsky"},
    {"leg", {{{nowhere, nowhere}, {nowhere, nowhere}}}, {knee, hip}, {"knee", ""}, "zatsiorsky"},
}};

// The landmarks of one side of a body, in metres.
class Points {
 public:
  Points(const Landmarks& landmarks, std::string_view part) : landmarks_(landmarks) {
    if (part.ends_with("_left")) side_ = "_left";
    if (part.ends_with("_right")) side_ = "_right";
    axes_ = trunk_axes(landmarks);
    trunk_known_ =
        landmarks.contains("neck") && landmarks.contains("hip_left") && landmarks.contains("hip_right");
  }
  // whether the trunk's axes are known; otherwise the patient's replace them
  bool trunk_known() const { return trunk_known_; }
  std::string name(std::string_view landmark) const {
    const std::string central(landmark);
    return landmarks_.contains(central) || side_.empty() ? central : central + side_;
  }
  std::optional<Vector3d> find(std::string_view landmark) const {
    const auto it = landmarks_.find(name(landmark));
    if (it != landmarks_.end()) return Vector3d(1e-3 * it->second.point);
    if (landmark != "mid_hip") return std::nullopt;
    const auto l = landmarks_.find("hip_left"), r = landmarks_.find("hip_right");
    if (l == landmarks_.end() || r == landmarks_.end()) return std::nullopt;
    return Vector3d(0.5e-3 * (l->second.point + r->second.point));
  }
  Vector3d up() const { return axes_.col(2); }
  Vector3d right() const { return -axes_.col(0); }
  Vector3d front() const { return -axes_.col(1); }
  Vector3d inwards() const { return side_ == "_left" ? right() : Vector3d(-right()); }
  // a line across a limb at "elbow" or "knee" or through the malleoli, pointing to the right
  std::optional<Vector3d> rightwards(std::string_view line) const {
    const bool malleoli = line == "malleolus";
    const auto medial = find(malleoli ? "medial_malleolus" : std::string(line) + "_medial");
    const auto lateral = find(malleoli ? "lateral_malleolus" : std::string(line) + "_lateral");
    if (line.empty() || !medial || !lateral) return std::nullopt;
    return Vector3d(side_ == "_left" ? *medial - *lateral : *lateral - *medial);
  }

 private:
  const Landmarks& landmarks_;
  std::string side_;
  Matrix3d axes_;
  bool trunk_known_ = false;
};

Matrix3d axes_of(const Vector3d& X, const Vector3d& Y) {
  Matrix3d axes;
  axes << X, Y, X.cross(Y);
  return axes;
}

Vector3d square_to(const Vector3d& v, const Vector3d& unit) { return (v - v.dot(unit) * unit).normalized(); }

// The axis of largest moment passes through the palm. Its sign: the palm faces forwards, inwards or in
// between, unless the forearm is rotated further inwards by more than 45 degrees.
void lay_hand(SegmentFrame& frame, const Vector3d& Y, const Points& points, const Inertial& inertial) {
  Vector3d X = square_to(inertial.principal().axes.col(2), Y);
  if (X.dot(points.front() + points.inwards()) < 0) X = -X;
  frame.R_WA = axes_of(X, Y);
  frame.axes = "Y from knuckle to wrist, X through the palm: the axis of largest moment";
}

void lay_foot(SegmentFrame& frame, const Vector3d& X, const Points& points) {
  const auto top = points.find("ankle"), back = points.find("heel");
  const Vector3d Y = square_to(top && back ? Vector3d(*top - *back) : points.up(), X);
  frame.R_WA = axes_of(X, Y);
  frame.axes = top ? "X from heel to toe, Y up to the ankle"
                   : "X from heel to toe, Y up along the trunk, because the ankle is missing";
}

void lay_limb(SegmentFrame& frame, const Vector3d& Y, const Points& points, const SegmentPlan& plan) {
  std::optional<Vector3d> right;
  for (const auto line : plan.line) {
    right = points.rightwards(line);
    if (!right) continue;
    frame.axes = line == "malleolus"
                     ? "Y along the joint centres, Z through the malleoli"
                     : fmt::format("Y along the joint centres, Z along the {}'s epicondyles", line);
    break;
  }
  if (!right)
    frame.axes = "Y along the joint centres, Z to the trunk's right, because the epicondyles are missing";
  const Vector3d X = Y.cross(right.value_or(points.right())).normalized();
  frame.R_WA = axes_of(X, Y);
}

// Sets the axes; false if the points of the long axis are missing.
bool lay_axes(SegmentFrame& frame, const Points& points, const SegmentPlan& plan, const Inertial& inertial) {
  if (plan.y[0].landmark.empty()) {
    frame.R_WA = axes_of(points.front(), points.up());
    frame.axes = points.trunk_known() ? std::string("the trunk's axes") : std::string(patients_axes);
    frame.long_axis = -points.up();
    return true;
  }
  const auto from = points.find(plan.y[0].landmark), to = points.find(plan.y[1].landmark);
  if (!from || !to || (*to - *from).norm() < 1e-6) return false;
  const Vector3d direction = (*to - *from).normalized();
  frame.long_axis = plan.segment == "foot" ? direction : Vector3d(-direction);
  if (plan.segment == "foot") {
    lay_foot(frame, direction, points);
  } else if (plan.segment == "hand") {
    lay_hand(frame, direction, points, inertial);
  } else if (plan.segment == "head") {
    frame.R_WA = axes_of(direction.cross(points.right()).normalized(), direction);
    frame.axes = "Y from neck to vertex, Z to the trunk's right";
  } else {
    lay_limb(frame, direction, points, plan);
  }
  return true;
}

const SegmentPlan* plan_of(std::string_view part) {
  for (const SegmentPlan& plan : plans)
    if (part == plan.segment ||
        (part.starts_with(plan.segment) && part.substr(plan.segment.size()) == "_left") ||
        (part.starts_with(plan.segment) && part.substr(plan.segment.size()) == "_right"))
      return &plan;
  return nullptr;
}

}  // namespace

std::optional<SegmentFrame> segment_frame(std::string_view part, const Landmarks& landmarks,
                                          const Inertial& inertial, std::string_view cuts) {
  const SegmentPlan* plan = plan_of(part);
  if (!plan) return std::nullopt;
  const Points points(landmarks, part);
  SegmentFrame frame;
  frame.segment = plan->segment;
  // dempster's planes differ from deleva1996's only above elbow and knee
  const bool planes = cuts == "deleva1996" || (cuts == "dempster" && plan->cuts == "joint");
  frame.cuts = planes ? plan->cuts : cuts;
  if (!lay_axes(frame, points, *plan, inertial)) return std::nullopt;
  for (const Endpoints& pair : plan->endpoints) {
    const auto from = points.find(pair[0].landmark), to = points.find(pair[1].landmark);
    if (!from || !to) continue;
    frame.from = pair[0].name, frame.to = pair[1].name;
    frame.from_point = *from, frame.to_point = *to;
    break;
  }
  // the patient's axes replace the trunk's if there is a length to measure along them
  const bool trunk = plan->y[0].landmark.empty();
  if (trunk && frame.from.empty() && !points.trunk_known()) return std::nullopt;
  return frame;
}

std::vector<std::string> endpoint_notes(const SegmentFrame& frame, std::string_view part,
                                        const Landmarks& landmarks, std::string_view known) {
  std::vector<std::string> notes;
  const Points points(landmarks, part);
  const SegmentPlan* plan = plan_of(part);
  if (!plan) return notes;
  for (const Endpoints& pair : plan->endpoints) {
    if (pair[0].name != frame.from || pair[1].name != frame.to) continue;
    for (const Endpoint& end : pair) {
      const std::string name = points.name(end.landmark);
      const auto it = landmarks.find(name);
      if (it != landmarks.end() && it->second.source.find("proportion") != std::string::npos &&
          known.find(in_words(name) + " placed by proportion") == std::string_view::npos)
        notes.push_back(fmt::format("{} is not visible; it was placed by proportion", end.name));
    }
    break;
  }
  return notes;
}

}  // namespace borelli
