// Scalar functions with their first two derivatives. As functions of time they drive switches, scale forces
// and move constraints. As functions of a coordinate they couple another one to it.
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "dynamics/numbers/cubic_spline.hpp"

namespace borelli {

/// f(t) and its first and second derivatives at one t.
template <class T>
struct TimeValueOf {
  T value = 0, rate = 0, acceleration = 0;
};
using TimeValue = TimeValueOf<double>;

/// c0 + c1 t + c2 t^2 + ... ; one coefficient is a constant, two a constant rate.
struct Polynomial {
  static constexpr std::string_view kind = "polynomial";
  std::vector<double> coefficients;

  void scale(double factor) {
    for (double& c : coefficients) c *= factor;
  }

  template <class T>
  TimeValueOf<T> operator()(const T& t) const {
    TimeValueOf<T> f;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {  // Horner for value, rate and
                                                                           // acceleration
      f.acceleration = f.acceleration * t + 2 * f.rate;
      f.rate = f.rate * t + f.value;
      f.value = f.value * t + *c;
    }
    return f;
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("coefficients", self.coefficients);
  }
};

/// offset + amplitude sin(angular_frequency t + phase); rad/s, rad.
struct Sine {
  static constexpr std::string_view kind = "sine";
  double amplitude = 1, angular_frequency = 1, phase = 0, offset = 0;

  void scale(double factor) {
    amplitude *= factor;
    offset *= factor;
  }

  template <class T>
  TimeValueOf<T> operator()(const T& t) const {
    using std::cos;
    using std::sin;
    const double w = angular_frequency;
    const T s = sin(w * t + phase), c = cos(w * t + phase);
    return {offset + amplitude * s, amplitude * w * c, -amplitude * w * w * s};
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("amplitude", self.amplitude);
    visit("angular_frequency", self.angular_frequency);
    visit("phase", self.phase);
    visit("offset", self.offset);
  }
};

/// The cubic spline through values at rising times, such as a measured motion. It is twice continuously
/// differentiable between its ends. `ends` sets the boundary conditions and the extrapolation (SplineEnds).
struct Table {
  static constexpr std::string_view kind = "table";
  std::vector<double> times, values;
  SplineEnds ends = SplineEnds::natural;

  Table() = default;
  Table(std::vector<double> at, std::vector<double> given, SplineEnds how = SplineEnds::natural)
      : times(std::move(at)), values(std::move(given)), ends(how) {
    prepare();
  }

  /// Builds the spline. Call it again after changing times, values or ends.
  void prepare() {
    spline_ = CubicSpline::complaint(times, values, ends).empty() ? CubicSpline(times, values, ends)
                                                                  : CubicSpline();
  }
  void scale(double factor) {
    for (double& value : values) value *= factor;
    prepare();
  }
  std::string complaint() const {
    const std::string bad = CubicSpline::complaint(times, values, ends);
    if (!bad.empty()) return "its table: " + bad;
    return spline_.knots() == times ? "" : "its table was changed; call prepare()";
  }

  template <class T>
  TimeValueOf<T> operator()(const T& t) const {
    if (spline_.empty()) return {};
    const SplineValue<T> at = spline_(t);
    return {at.value, at.slope, at.curvature};
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("times", self.times);
    visit("values", self.values);
    visit("ends", self.ends);
  }

 private:
  CubicSpline spline_;
};

/// To add a function, write a struct like those above and list it here.
using TimeFunction = std::variant<Polynomial, Sine, Table>;

inline TimeFunction constant(double value) { return Polynomial{{value}}; }
inline TimeFunction linear(double value, double rate) { return Polynomial{{value, rate}}; }

/// `factor` times a function.
inline TimeFunction scaled(TimeFunction function, double factor) {
  std::visit([=](auto& f) { f.scale(factor); }, function);
  return function;
}

inline TimeValue at(const TimeFunction& f, double t) {
  return std::visit([t](const auto& function) { return function(t); }, f);
}
template <class T>
requires(!std::is_arithmetic_v<T>) TimeValueOf<T> at(const TimeFunction& f, const T& t) {
  return std::visit([&t](const auto& function) { return function(t); }, f);
}

/// Why a function cannot be evaluated; empty: it can.
inline std::string complaint_of(const TimeFunction& f) {
  if (const auto* table = std::get_if<Table>(&f))
    if (const std::string bad = table->complaint(); !bad.empty()) return bad;
  return std::isfinite(at(f, 0).value) && std::isfinite(at(f, 1).value)
             ? ""
             : "its function does not give finite numbers";
}

}  // namespace borelli
