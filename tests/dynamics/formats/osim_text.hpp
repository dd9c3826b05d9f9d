// Small OpenSim models in both layouts, from one list of bodies.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <functional>
#include <string>
#include <vector>

namespace borelli::test {

/// An axis of a CustomJoint: its function as XML and as code.
struct OsimAxis {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  std::string coordinate;  // empty: none
  std::string function;    // XML
  std::function<double(double x, int order)> by;
};

/// A body and its joint to the parent.
struct OsimPart {
  std::string name, parent, joint;
  std::vector<std::string> coordinates;
  Eigen::Vector3d place_in_parent, angles_in_parent, place, angles;
  double mass = 2;
  Eigen::Vector3d centre{0.02, -0.2, 0.03};
  double inertia[6] = {0.05, 0.02, 0.06, 0.001, -0.002, 0.003};
  std::vector<OsimAxis> axes = {};  ///< of a CustomJoint: rotations, then translations
  std::string said = {};            ///< XML added to its first coordinate
  bool reversed = false;
};

/// The cubic spline of Forsythe, Malcolm and Moler ("spline"), solved for the slopes at the knots. Pieces are
/// polynomials of the distance to the previous knot; beyond the ends it is a line.
class ForsytheSpline {
 public:
  ForsytheSpline(std::vector<double> x, std::vector<double> y) : x_(std::move(x)), y_(std::move(y)) {
    const int n = int(x_.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b(n);
    for (int i = 1; i + 1 < n; ++i) {
      A(i, i - 1) = 1 / width(i - 1);
      A(i, i + 1) = 1 / width(i);
      A(i, i) = 2 * (A(i, i - 1) + A(i, i + 1));
      b[i] = 3 * (rise(i - 1) / width(i - 1) + rise(i) / width(i));
    }
    for (const int end : {0, n - 1}) {
      const int piece = end == 0 ? 0 : n - 2, first = end == 0 ? 0 : n - 4;
      A(end, piece) = A(end, piece + 1) = 1;
      b[end] = 2 * rise(piece) + width(piece) * width(piece) * cubic(first);
    }
    slope_ = A.fullPivLu().solve(b);
  }
  double operator()(double x, int order) const {
    const int last = int(x_.size()) - 1;
    const int end = x < x_[0] ? 0 : x > x_[last] ? last : -1;
    if (end >= 0) return order == 0 ? y_[end] + slope_[end] * (x - x_[end]) : order == 1 ? slope_[end] : 0;
    int i = 0;
    while (i + 2 <= last && x > x_[i + 1]) ++i;
    const double h = width(i), d = x - x_[i], c3 = (slope_[i] + slope_[i + 1] - 2 * rise(i)) / (h * h),
                 c2 = (rise(i) - slope_[i]) / h - c3 * h;
    if (order == 0) return y_[i] + d * (slope_[i] + d * (c2 + d * c3));
    return order == 1 ? slope_[i] + d * (2 * c2 + 3 * d * c3) : 2 * c2 + 6 * d * c3;
  }

 private:
  double width(int i) const { return x_[i + 1] - x_[i]; }
  double rise(int i) const { return (y_[i + 1] - y_[i]) / width(i); }
  /// The cubic coefficient through four values: a divided difference.
  double cubic(int i) const {
    const auto second = [&](int k) { return (rise(k + 1) - rise(k)) / (x_[k + 2] - x_[k]); };
    return (second(i + 1) - second(i)) / (x_[i + 3] - x_[i]);
  }
  std::vector<double> x_, y_;
  Eigen::VectorXd slope_;
};

inline std::string numbers_text(const std::vector<double>& x) { return fmt::format("{}", fmt::join(x, " ")); }
inline std::string numbers_text(const Eigen::Vector3d& v) {
  return fmt::format("{} {} {}", v[0], v[1], v[2]);
}

inline OsimAxis still_axis(const Eigen::Vector3d& axis, double value = 0) {
  return {axis, "", fmt::format("<Constant><value>{}</value></Constant>", value),
          [value](double, int order) { return order == 0 ? value : 0; }};
}
inline OsimAxis linear_axis(const Eigen::Vector3d& axis, const std::string& name, double slope = 1,
                            double value = 0) {
  return {axis, name,
          fmt::format("<LinearFunction><coefficients> {} {}</coefficients></LinearFunction>", slope, value),
          [=](double x, int order) { return order == 0   ? slope * x + value
                                            : order == 1 ? slope
                                                         : 0; }};
}
/// `scale` times a spline.
inline OsimAxis spline_axis(const Eigen::Vector3d& axis, const std::string& name,
                            const std::vector<double>& x, const std::vector<double>& y, double scale) {
  const ForsytheSpline spline(x, y);
  return {axis, name,
          fmt::format("<MultiplierFunction><function><SimmSpline><x> {}</x><y> {}</y></SimmSpline></function>"
                      "<scale>{}</scale></MultiplierFunction>",
                      numbers_text(x), numbers_text(y), scale),
          [=](double at, int order) { return scale * spline(at, order); }};
}

/// A free body that carries one body by each other type of joint, such as a hip with three coordinates and a
/// knee with one.
inline std::vector<OsimPart> all_joints() {
  const Eigen::Vector3d p(0.1, -0.3, 0.05), turn(0.3, -0.5, 0.8), c(0.02, 0.1, -0.04), back(-0.2, 0.4, 0.1);
  const auto part = [&](const std::string& name, const std::string& parent, const std::string& joint,
                        const std::vector<std::string>& coordinates) {
    return OsimPart{name, parent, joint, coordinates, p, turn, c, back};
  };
  const Eigen::Vector3d X = Eigen::Vector3d::UnitX(), Y = Eigen::Vector3d::UnitY(),
                        Z = Eigen::Vector3d::UnitZ();
  std::vector<OsimPart> out{
      part("pelvis", "ground", "FreeJoint",
           {"pelvis_rx", "pelvis_ry", "pelvis_rz", "pelvis_tx", "pelvis_ty", "pelvis_tz"}),
      part("upper", "pelvis", "PinJoint", {"pin_q"}),
      part("lower", "upper", "SliderJoint", {"slider_q"}),
      part("head", "pelvis", "BallJoint", {"ball_x", "ball_y", "ball_z"}),
      part("hand", "lower", "UniversalJoint", {"universal_x", "universal_y"}),
      part("plate", "head", "PlanarJoint", {"planar_r", "planar_x", "planar_y"}),
      part("tail", "pelvis", "GimbalJoint", {"gimbal_x", "gimbal_y", "gimbal_z"}),
      part("tip", "tail", "WeldJoint", {}),
      part("femur", "pelvis", "CustomJoint", {"hip_flexion", "hip_adduction", "hip_rotation"}),
      part("tibia", "femur", "CustomJoint", {"knee_angle"})};
  const Eigen::Vector3d askew = Eigen::Vector3d(1, 0.2, -0.3).normalized();
  out[8].axes = {linear_axis(Z, "hip_flexion"),
                 linear_axis(askew, "hip_adduction", -1, 0.1),
                 linear_axis(Y, "hip_rotation", 1.5),
                 still_axis(X, 0.02),
                 still_axis(Y),
                 still_axis(Z, -0.01)};
  const std::vector<double> x{-1.2, -0.7, -0.3, 0.1, 0.5, 0.8};
  out[9].axes = {linear_axis(Z, "knee_angle"),
                 spline_axis(askew, "knee_angle", x, {0.3, 0.1, -0.1, 0.05, 0.2, 0.6}, 0.8),
                 still_axis(Y, 0.15),
                 spline_axis(X, "knee_angle", x, {0.01, 0.03, 0.02, -0.02, -0.01, 0.04}, 1.1),
                 spline_axis(Y, "knee_angle", x, {-0.4, -0.41, -0.39, -0.4, -0.42, -0.4}, 0.9),
                 still_axis(Z, 0.015)};
  return out;
}

/// A knee on the ground whose three rotations depend on one coordinate, as in Rajagopal's model.
inline OsimPart turning_knee() {
  OsimPart out = all_joints().back();
  out.parent = "ground";
  out.axes[2] = spline_axis(Eigen::Vector3d::UnitY(), "knee_angle", {-1.2, -0.7, -0.3, 0.1, 0.5, 0.8},
                            {-0.2, 0.1, 0.2, 0.15, -0.1, -0.3}, 1);
  return out;
}

inline std::string mass_text(const OsimPart& part) {
  return fmt::format("<mass>{}</mass><mass_center>{}</mass_center>", part.mass, numbers_text(part.centre));
}

inline std::string coordinates_text(const OsimPart& part) {
  std::string out;
  for (const std::string& name : part.coordinates)
    out += fmt::format("<Coordinate name=\"{}\">{}</Coordinate>", name,
                       name == part.coordinates.front() ? part.said : "");
  return out;
}

/// `wrapped`: OpenSim 3 has the function in <function>.
inline std::string transform_text(const OsimPart& part, bool wrapped) {
  if (part.axes.empty()) return "";
  static const char* names[] = {"rotation1",    "rotation2",    "rotation3",
                                "translation1", "translation2", "translation3"};
  std::string out = "<SpatialTransform>";
  for (int i = 0; i < 6; ++i) {
    const OsimAxis& axis = part.axes[i];
    const std::string function = wrapped ? "<function>" + axis.function + "</function>" : axis.function;
    out += fmt::format(
        "<TransformAxis name=\"{}\"><coordinates>{}</coordinates><axis> {}</axis>{}</TransformAxis>",
        names[i], axis.coordinate, numbers_text(axis.axis), function);
  }
  return out + "</SpatialTransform>";
}

/// The layout of OpenSim 3: joints inside bodies.
inline std::string old_layout(const std::vector<OsimPart>& parts) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<OpenSimDocument Version=\"30000\"><Model name=\"m\"><gravity> 0 -9.80665 0"
      "</gravity><BodySet><objects><Body name=\"ground\"><mass>0</mass><Joint /></Body>\n";
  for (const OsimPart& part : parts) {
    const double* I = part.inertia;
    out += fmt::format(
        "<Body "
        "name=\"{}\">{}<inertia_xx>{}</inertia_xx><inertia_yy>{}</inertia_yy><inertia_zz>{}</inertia_zz>"
        "<inertia_xy>{}</inertia_xy><inertia_xz>{}</inertia_xz><inertia_yz>{}</inertia_yz>\n<Joint><{} "
        "name=\"{}_joint\"><parent_body>{}</parent_body><location_in_parent>{}</location_in_parent>"
        "<orientation_in_parent>{}</orientation_in_parent><location>{}</location><orientation>{}</"
        "orientation>"
        "<CoordinateSet><objects>{}</objects></CoordinateSet><reverse>{}</reverse>{}</{}></Joint></Body>\n",
        part.name, mass_text(part), I[0], I[1], I[2], I[3], I[4], I[5], part.joint, part.name, part.parent,
        numbers_text(part.place_in_parent), numbers_text(part.angles_in_parent), numbers_text(part.place),
        numbers_text(part.angles), coordinates_text(part), part.reversed, transform_text(part, true),
        part.joint);
  }
  return out + "</objects><groups /></BodySet></Model></OpenSimDocument>\n";
}

/// The layout of OpenSim 4: sockets and offset frames; `sets` are added to the model.
inline std::string new_layout(const std::vector<OsimPart>& parts, const std::string& sets = "") {
  std::string out =
      "<?xml version=\"1.0\"?>\n<OpenSimDocument Version=\"40000\"><Model name=\"m\"><Ground "
      "name=\"ground\"/>"
      "<gravity>0 -9.80665 0</gravity><BodySet name=\"bodyset\"><objects>\n";
  for (const OsimPart& part : parts)
    out += fmt::format("<Body name=\"{}\">{}<inertia>{}</inertia></Body>\n", part.name, mass_text(part),
                       fmt::join(part.inertia, part.inertia + 6, " "));
  out += "</objects></BodySet><JointSet name=\"jointset\"><objects>\n";
  const auto frame = [](const std::string& name, const std::string& body, const Eigen::Vector3d& place,
                        const Eigen::Vector3d& angles) {
    return fmt::format(
        "<PhysicalOffsetFrame name=\"{}\"><socket_parent>{}</socket_parent><translation>{}"
        "</translation><orientation>{}</orientation></PhysicalOffsetFrame>",
        name, body, numbers_text(place), numbers_text(angles));
  };
  for (const OsimPart& part : parts) {
    const std::string parent = part.parent == "ground" ? "/ground" : "/bodyset/" + part.parent;
    out += fmt::format(
        "<{} name=\"{}_joint\"><socket_parent_frame>in_parent</socket_parent_frame>"
        "<socket_child_frame>in_body</socket_child_frame><coordinates>{}</coordinates><frames>{}{}"
        "</frames>{}</{}>\n",
        part.joint, part.name, coordinates_text(part),
        frame("in_parent", parent, part.place_in_parent, part.angles_in_parent),
        frame("in_body", "/bodyset/" + part.name, part.place, part.angles), transform_text(part, false),
        part.joint);
  }
  return out + "</objects></JointSet>" + sets + "</Model></OpenSimDocument>\n";
}

}  // namespace borelli::test
