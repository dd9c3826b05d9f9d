#include "pipeline/body/isb_frames.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <string>

namespace borelli {
namespace {

using Eigen::Vector3d;

// Landmarks of a part on its side, in metres; stores the first missing one.
class Seen {
 public:
  Seen(const Landmarks& landmarks, std::string_view part) : landmarks_(landmarks) {
    if (part.ends_with("_left")) side_ = "_left";
    if (part.ends_with("_right")) side_ = "_right";
  }
  Vector3d operator()(const std::string& name) { return at(name + side_); }
  Vector3d at(const std::string& name) {
    const auto it = landmarks_.find(name);
    if (it != landmarks_.end()) return 1e-3 * it->second.point;
    if (missing.empty()) missing = name;
    return Vector3d::Zero();
  }
  // a line across the limb that points to the right
  Vector3d rightwards(const Vector3d& medial, const Vector3d& lateral) const {
    return side_ == "_left" ? Vector3d(medial - lateral) : Vector3d(lateral - medial);
  }
  std::string missing;

 private:
  const Landmarks& landmarks_;
  std::string side_;
};

Vector3d middle(const Vector3d& a, const Vector3d& b) { return 0.5 * (a + b); }

struct Laid {
  Vector3d origin, X, Y;  // Y is kept, X is made normal to it
  std::string origin_name, axes;
};

// Frame of a bone with a ball joint at its top and a hinge with epicondyles at its end.
Laid from_ball(Seen& seen, const std::string& ball, const std::string& hinge, const char* origin,
               const char* axes) {
  const Vector3d medial = seen(hinge + "_medial"), lateral = seen(hinge + "_lateral"), top = seen(ball);
  const Vector3d Y = top - middle(medial, lateral);
  return {top, Y.cross(seen.rightwards(medial, lateral)), Y, origin, axes};
}

Laid lay(std::string_view segment, Seen& seen) {
  if (segment == "lower_trunk") {
    const Vector3d left = seen.at("asis_left"), right = seen.at("asis_right"), Z = right - left;
    const Vector3d psis_left = seen.at("psis_left"), psis_right = seen.at("psis_right");
    const Vector3d front = middle(left, right), back = middle(psis_left, psis_right);
    const Vector3d Y = Z.cross(front - back);
    return {front, Y.cross(Z), Y, "mid-ASIS", "ISB pelvis: Z through both ASIS, Y normal to ASIS and PSIS"};
  }
  if (segment == "upper_trunk") {
    const Vector3d notch = seen.at("suprasternale"), c7 = seen.at("cervicale");
    const Vector3d Y = middle(notch, c7) - middle(seen.at("xiphion"), seen.at("t8"));
    return {notch, Y.cross((notch - c7).cross(Y)), Y, "suprasternale",
            "ISB thorax: Y from xiphion and T8 to suprasternale and C7"};
  }
  if (segment == "forearm") {
    const Vector3d ulna = seen("ulnar_styloid"), radius = seen("radial_styloid");
    const Vector3d Y = middle(seen("elbow_medial"), seen("elbow_lateral")) - ulna;
    return {ulna, Y.cross(seen.rightwards(ulna, radius)), Y, "ulnar styloid",
            "ISB forearm: Y from the ulnar styloid to the epicondyles' middle, Z towards the radial styloid"};
  }
  if (segment == "upper_arm")
    return from_ball(seen, "shoulder", "elbow", "shoulder joint centre",
                     "ISB humerus: Y from the epicondyles' middle to the shoulder, Z along their line");
  if (segment == "thigh")
    return from_ball(seen, "hip", "knee", "hip joint centre",
                     "ISB femur: Y from the epicondyles' middle to the hip, Z along their line");
  if (segment == "shank") {
    const Vector3d medial = seen("medial_malleolus"), lateral = seen("lateral_malleolus");
    const Vector3d Y = middle(seen("knee_medial"), seen("knee_lateral")) - middle(medial, lateral);
    return {middle(medial, lateral), Y.cross(seen.rightwards(medial, lateral)), Y, "middle of the malleoli",
            "ISB shank: Y from the malleoli's to the epicondyles' middle, Z through the malleoli"};
  }
  const Vector3d heel = seen("heel"), fifth = seen("metatarsal_5");
  const Vector3d X = middle(seen("metatarsal_1"), fifth) - heel;
  const Vector3d right = seen.rightwards(seen("metatarsal_2"), fifth);
  const Vector3d Y = (right - right.dot(X) / X.squaredNorm() * X).cross(X);
  return {heel, X, Y, "heel", "ISB foot: X from the heel to the metatarsal heads, Y normal to them"};
}

}  // namespace

std::string lay_isb_frame(SegmentFrame& frame, std::string_view part, const Landmarks& landmarks) {
  if (frame.segment == "head" || frame.segment == "middle_trunk" || frame.segment == "hand" ||
      frame.segment == "trunk" || frame.segment == "arm" || frame.segment == "leg") {
    frame.axes += " (the ISB defines none for this segment)";
    return "";
  }
  Seen seen(landmarks, part);
  const Laid laid = lay(frame.segment, seen);
  if (!seen.missing.empty()) {
    frame.axes += fmt::format(" (not the ISB's, because {} is missing)", seen.missing);
    return seen.missing;
  }
  const Vector3d Y = laid.Y.normalized(), X = (laid.X - laid.X.dot(Y) * Y).normalized();
  frame.R_WA << X, Y, X.cross(Y);
  frame.axes = laid.axes;
  frame.origin = laid.origin, frame.origin_name = laid.origin_name;
  return "";
}

}  // namespace borelli
