// Functions of time with their first two derivatives: what drives a switch, scales a force, moves a
// constraint.
#pragma once

#include <cmath>
#include <string_view>
#include <variant>
#include <vector>

namespace borelli {

/// f(t) and its first and second derivatives at one t.
struct TimeValue {
  double value = 0, rate = 0, acceleration = 0;
};

/// c0 + c1 t + c2 t^2 + ... ; one coefficient is a constant, two a constant rate.
struct Polynomial {
  static constexpr std::string_view kind = "polynomial";
  std::vector<double> coefficients;

  TimeValue operator()(double t) const {
    TimeValue f;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {  // Horner, on all three at once
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

  TimeValue operator()(double t) const {
    const double w = angular_frequency, s = std::sin(w * t + phase), c = std::cos(w * t + phase);
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

/// A new function is one struct like the above, and its name here.
using TimeFunction = std::variant<Polynomial, Sine>;

inline TimeFunction constant(double value) { return Polynomial{{value}}; }
inline TimeFunction linear(double value, double rate) { return Polynomial{{value, rate}}; }

inline TimeValue at(const TimeFunction& f, double t) {
  return std::visit([t](const auto& function) { return function(t); }, f);
}

}  // namespace borelli
