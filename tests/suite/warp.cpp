#include "tests/suite/warp.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace borelli::suite {
namespace {

using Eigen::AngleAxisd, Eigen::Matrix3d, Eigen::Vector3d;

class Drawing {
 public:
  Drawing(Warp& warp, std::uint64_t seed, int attempt)
      : warp_(warp),
        body_(seed * 4 + 1),
        pose_(seed * 1000003 + std::uint64_t(attempt) + 2),
        scanner_(seed * 4 + 3),
        calm_(std::pow(0.85, attempt)) {}

  void all() {
    shape();
    arms();
    legs();
    trunk();
    loss();
    scan();
    std::sort(warp_.kinds.begin(), warp_.kinds.end());
  }

 private:
  using Random = std::mt19937_64;
  // own formulas, because the standard's distributions differ between libraries
  static double uniform(Random& random, double low, double high) {
    return low + (high - low) * (double(random() >> 11) * 0x1p-53);
  }
  static bool chance(Random& random, double share) { return uniform(random, 0, 1) < share; }
  static int pick(Random& random, int count) { return int(uniform(random, 0, count)); }
  double angle(double low, double high) {  // rad
    return uniform(pose_, low, high) * std::numbers::pi / 180;
  }
  void kind(const std::string& name) { warp_.kinds.push_back(name); }
  Vector3d& turn(const std::string& joint) { return warp_.motion.turn[joint_index(joint)]; }
  static std::size_t at(const std::string& part) { return static_cast<std::size_t>(part_label(part)); }

  void shape() {
    Motion& m = warp_.motion;
    const double size = uniform(body_, 0.88, 1.17);
    const double trunk = uniform(body_, 0.94, 1.06), arm = uniform(body_, 0.92, 1.08),
                 leg = uniform(body_, 0.92, 1.08), girth = uniform(body_, 0.94, 1.06);
    const bool uneven = chance(body_, 0.3);
    if (uneven) kind("asymmetric");
    const double fatness = chance(body_, 0.3) ? uniform(body_, 15, 45) : uniform(body_, -6, 15);
    if (fatness > 18) kind("obese");
    if (fatness < -3) kind("thin");
    for (std::size_t p = 1; p < parts.size(); ++p) {
      const std::string_view name = parts[p].name;
      const bool axial = is_axial(int(p));
      const bool of_leg = name.starts_with("thigh") || name.starts_with("shank") || name.starts_with("foot");
      m.length[p] = size *
                    (axial    ? (name == "head" ? 1 : trunk)
                     : of_leg ? leg
                              : arm) *
                    uniform(body_, 0.98, 1.02);
      m.girth[p] = size * girth;
      if (uneven && name.ends_with("_left")) m.length[p] *= uniform(body_, 0.95, 1.05);
      const double share = name == "head"                                               ? 0.15
                           : name.starts_with("hand") || name.starts_with("foot")       ? 0.1
                           : name.starts_with("forearm")                                ? 0.35
                           : name.starts_with("upper_arm") || name.starts_with("shank") ? 0.5
                           : name.starts_with("thigh")                                  ? 0.7
                           : name == "upper_trunk"                                      ? 0.6
                                                                                        : 1.0;
      m.fat[p] = fatness * share;
    }
    m.length[at("head")] = m.girth[at("head")] = 0.5 * size + 0.5;  // heads differ less than bodies
  }

  // Shoulder and elbow of one side, degrees as in anatomy; rotation inwards is positive.
  void arm(bool left, double flexion, double abduction, double rotation, double elbow) {
    const double s = left ? 1 : -1;
    const Matrix3d R = (AngleAxisd(-s * abduction * calm_, Vector3d::UnitY()) *
                        AngleAxisd(-flexion * calm_, Vector3d::UnitX()) *
                        AngleAxisd(-s * rotation * calm_, Vector3d::UnitZ()))
                           .toRotationMatrix();
    const AngleAxisd whole(R);
    const std::string side = left ? "_left" : "_right";
    turn("shoulder" + side) = whole.angle() * whole.axis();
    // about the axis across, forearm to the front
    turn("elbow" + side) = -elbow * calm_ * Vector3d(1, -s * 0.35, 0).normalized();
    turn("wrist" + side) = angle(-25, 25) * Vector3d::UnitX();
    warp_.motion.pronation[left ? 0 : 1] = -s * angle(-60, 60);
  }

  void arms() {
    const int pose = pick(pose_, 9);
    const bool alike = chance(pose_, 0.5);
    constexpr std::array<const char*, 9> names{"arms beside trunk",     "arms raised",       "arms abducted",
                                               "arms crossed on belly", "hands behind back", "one arm raised",
                                               "arms beside trunk",     "arms raised",       "arms flexed"};
    kind(names[std::size_t(pose)]);
    for (const bool left : {true, false}) {
      if (pose == 1 || pose == 7 || (pose == 5 && left))
        arm(left, angle(0, 20), angle(120, 165), angle(-40, 10), angle(5, 70));
      else if (pose == 2)
        arm(left, angle(-10, 25), angle(25, 95), angle(-20, 30), angle(0, 60));
      else if (pose == 3)
        arm(left, angle(18, 30), angle(6, 16), angle(45, 70), angle(65, 90));
      else if (pose == 4)
        arm(left, angle(-38, -28), angle(5, 14), angle(80, 105), angle(35, 60));
      else if (pose == 8)
        arm(left, angle(30, 100), angle(5, 30), angle(-10, 30), angle(10, 110));
      else
        arm(left, angle(-4, 8), angle(-1, 12), angle(-15, 25), angle(0, 25));
    }
    if (alike && pose != 5) {  // mirrored: a rotation vector's x stays, y and z change sign
      const auto mirror = [](const Vector3d& v) { return Vector3d(v.x(), -v.y(), -v.z()); };
      for (const char* joint : {"shoulder", "elbow", "wrist"})
        turn(std::string(joint) + "_right") = mirror(turn(std::string(joint) + "_left"));
    }
  }

  void leg(bool left, double flexion, double abduction, double rotation, double knee) {
    const double s = left ? 1 : -1;
    const Matrix3d R = (AngleAxisd(-s * abduction * calm_, Vector3d::UnitY()) *
                        AngleAxisd(-flexion * calm_, Vector3d::UnitX()) *
                        AngleAxisd(-s * rotation * calm_, Vector3d::UnitZ()))
                           .toRotationMatrix();
    const AngleAxisd whole(R);
    const std::string side = left ? "_left" : "_right";
    turn("hip" + side) = whole.angle() * whole.axis();
    turn("knee" + side) = knee * calm_ * Vector3d::UnitX();
    turn("ankle" + side) = angle(-12, 20) * Vector3d::UnitX();
  }

  void legs() {
    const int pose = pick(pose_, 6);
    constexpr std::array<const char*, 6> names{"legs as they lie", "legs apart", "legs touching",
                                               "legs crossed",     "knees bent", "one knee bent"};
    kind(names[std::size_t(pose)]);
    const bool first = chance(pose_, 0.5);
    for (const bool left : {true, false}) {
      if (pose == 1)
        leg(left, angle(0, 8), angle(6, 20), angle(-25, 5), angle(0, 10));
      else if (pose == 2)
        leg(left, angle(0, 5), angle(-3, 0), angle(-5, 5), angle(0, 5));
      else if (pose == 3)
        leg(left, left == first ? angle(14, 20) : angle(0, 2), left == first ? angle(-14, -9) : angle(-1, 2),
            angle(-5, 5), angle(2, 8));
      else if (pose == 4 || (pose == 5 && left == first))
        leg(left, angle(25, 50), angle(2, 12), angle(-10, 5), angle(40, 85));
      else
        leg(left, angle(0, 6), angle(0, 7), angle(-15, 10), angle(0, 10));
    }
  }

  void trunk() {
    if (chance(pose_, 0.5)) {
      kind("trunk bent");
      turn("spine_lower") = {angle(-14, 8), angle(-12, 12), angle(-14, 14)};
      turn("spine_upper") = {angle(-10, 8), angle(-8, 8), angle(-10, 10)};
    }
    turn("neck") = {angle(-20, 14), angle(-8, 8), angle(-10, 10)};
    if (chance(pose_, 0.3)) {
      kind("head turned");
      turn("neck").z() = (chance(pose_, 0.5) ? 1 : -1) * angle(25, 55);
    }
    const int choice = pick(body_, 10);
    double about = uniform(body_, -6, 6);
    if (choice == 0) about += chance(body_, 0.5) ? 90 : -90, kind("lying on a side");
    if (choice == 1) about += 180, kind("prone");
    constexpr double degree = std::numbers::pi / 180;
    warp_.motion.whole = (AngleAxisd(uniform(body_, -4, 4) * degree, Vector3d::UnitX()) *
                          AngleAxisd(uniform(body_, -4, 4) * degree, Vector3d::UnitY()) *
                          AngleAxisd(about * degree, Vector3d::UnitZ()))
                             .toRotationMatrix();
  }

  void loss() {
    const double at_all = uniform(body_, 0, 1);
    const bool left = chance(body_, 0.5);
    const std::string side = left ? "_left" : "_right", word = left ? "left " : "right ";
    const int which = pick(body_, 6);
    const double from = uniform(body_, 0.35, 0.8);
    const bool artificial = chance(body_, 0.4);
    if (at_all < 0.3) {
      constexpr std::array<const char*, 6> stems{"thigh", "upper_arm", "thigh",
                                                 "shank", "upper_arm", "forearm"};
      const bool whole = which < 2;
      const std::string stem = stems[std::size_t(which)];
      warp_.loss = Loss{int(at(stem + side)), whole ? 0 : from, stem == "shank" && artificial};
      if (whole)
        kind(word + (stem == "thigh" ? "leg" : "arm") + " missing");
      else
        kind("stump in " + word + (stem == "upper_arm" ? "upper arm" : stem));
      kind("limb missing");
      if (warp_.loss->artificial) kind("artificial shank");
    } else if (at_all < 0.4) {
      warp_.metal_hip = left ? 1 : 2;
      kind("metal hip");
    }
  }

  void scan() {
    Scanner& s = warp_.scanner;
    constexpr std::array<double, 8> slices{1, 1.5, 2, 3, 4, 5, 7, 10};
    const double slice = slices[std::size_t(pick(scanner_, 8))];
    double plane = uniform(scanner_, 1, 3);
    constexpr std::array<View, 12> views{View::whole, View::whole,   View::whole,     View::no_head,
                                         View::trunk, View::chest,   View::abdomen,   View::pelvis,
                                         View::legs,  View::one_leg, View::head_neck, View::arms_and_trunk};
    constexpr std::array<const char*, 12> names{
        "whole body", "whole body", "whole body", "without head", "trunk",         "chest",
        "abdomen",    "pelvis",     "legs",       "one leg",      "head and neck", "trunk with arms"};
    const auto v = std::size_t(pick(scanner_, 12));
    s.view = views[v], s.left = chance(scanner_, 0.5);
    s.shift = uniform(scanner_, -40, 40);
    kind(names[v]);
    // at most about 60 million voxels
    const double length = s.view == View::whole ? 1900 : 900;
    plane = std::max(plane, std::sqrt(700 * 350 * length / (60e6 * slice)));
    s.spacing = {plane, plane, slice};
    if (slice >= 5) kind("thick slices");
    if (chance(scanner_, 0.25)) {
      for (int c = 0; c < 3; ++c) s.rotation_deg[c] = uniform(scanner_, -12, 12);
      kind("oblique grid");
    }
    if (chance(scanner_, 0.15)) s.tilt_deg = uniform(scanner_, -20, 20), kind("tilted gantry");
    for (int c = 0; c < 3; ++c) s.offset[c] = uniform(scanner_, -1, 1);
    s.effects.seed = warp_.seed;
    s.effects.noise_hu = chance(scanner_, 0.3) ? uniform(scanner_, 50, 150) : uniform(scanner_, 10, 50);
    if (s.effects.noise_hu > 70) kind("noise");
    s.effects.blur_mm = uniform(scanner_, 0.4, 1.2);
    if (warp_.metal_hip || (warp_.loss && warp_.loss->artificial))
      s.effects.streaks_hu = uniform(scanner_, 100, 700);
    s.effects.table = chance(scanner_, 0.6), s.effects.blanket = chance(scanner_, 0.2);
    if (s.effects.table) kind("table");
    if (s.effects.blanket) kind("blanket");
    if (chance(scanner_, 0.25)) s.gut_hu = uniform(scanner_, 100, 400), kind("contrast in gut");
    if (chance(scanner_, 0.3)) s.vessel_hu = uniform(scanner_, 80, 350), kind("contrast in vessels");
    if (chance(scanner_, 0.15)) s.effects.field_of_view = uniform(scanner_, 360, 500), kind("round view");
    if (chance(scanner_, 0.1)) {
      s.eight_bits = true, s.window_low = -200, s.window_high = uniform(scanner_, 300, 1000);
      if (chance(scanner_, 0.5)) s.window_low = -1000;
      kind("8-bit window");
    }
  }

  Warp& warp_;
  Random body_, pose_, scanner_;
  double calm_;
};

}  // namespace

Warp rest_warp() {
  Warp out;
  out.scanner.spacing = {3, 3, 3};
  out.kinds = {"at rest"};
  return out;
}

Warp drawn_warp(std::uint64_t seed, int attempt) {
  Warp out;
  out.seed = seed;
  Drawing(out, seed, attempt).all();
  return out;
}

}  // namespace borelli::suite
