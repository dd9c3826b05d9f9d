// Efforts in closed form: each shank is a pendulum that swings about a tilted mean.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

namespace borelli::test {

/// theta = mean + amplitude sin(rate (t - start)); the muscles' moment = m g c sin(theta) + I theta''.
struct Pendulum {
  double mass = 4, arm = 0.2, inertia = 0.25, mean = 0.3, amplitude = 0.5, rate = std::numbers::pi, start = 0;

  double angle(double t) const { return mean + amplitude * std::sin(rate * (t - start)); }
  double speed(double t) const { return amplitude * rate * std::cos(rate * (t - start)); }
  double moment(double t) const {
    const double acceleration = -amplitude * rate * rate * std::sin(rate * (t - start));
    return mass * 9.81 * arm * std::sin(angle(t)) + inertia * acceleration;
  }
  double power(double t) const { return moment(t) * speed(t); }
  /// The largest moment, at the swing's end, because the moment grows with sin(rate (t - start)).
  double peak() const {
    return mass * 9.81 * arm * std::sin(mean + amplitude) - inertia * amplitude * rate * rate;
  }
};

inline Pendulum left_shank() { return {}; }
/// Half the masses, half a period later.
inline Pendulum right_shank() { return {.mass = 2, .inertia = 0.125, .start = 1}; }

/// Two seconds of efforts in the form of effort_report. The deviation is a tenth of the moment. The hip,
/// which comes first, has three coordinates and no deviations. The force under the left foot grows from 0 to
/// 1000 N and has no point of application in the first 0.2 s.
inline nlohmann::json pendulum_efforts(const std::string& source, double from = 0) {
  using nlohmann::json;
  json efforts{{"source", source},           {"mass_kg", 50},
               {"times", json::array()},     {"coordinates", json::array()},
               {"residuals", json::array()}, {"forces", json::array()}};
  const auto series = [](const auto& value_at) {
    json list = json::array();
    for (int i = 0; i <= 200; ++i) list.push_back(value_at(i * 0.01));
    return list;
  };
  efforts["times"] = series([&](double t) { return from + t; });
  int axis = 0;
  for (const char* motion : {"flexion", "adduction", "internal rotation"})
    efforts["coordinates"].push_back({{"name", std::string("hip_left.") + "xyz"[axis++]},
                                      {"label", std::string("left hip, ") + motion},
                                      {"joint", "hip_left"},
                                      {"solid", "thigh_left"},
                                      {"angle_deg", series([&](double t) { return 10 * t; })},
                                      {"moment", series([&](double t) { return axis * (t - 3); })},
                                      {"power", series([&](double) { return 0; })}});
  for (const std::string side : {"right", "left"}) {
    const Pendulum shank = side == "left" ? left_shank() : right_shank();
    efforts["coordinates"].push_back(
        {{"name", "knee_" + side},
         {"label", side + " knee, flexion"},
         {"joint", "knee_" + side},
         {"solid", "shank_" + side},
         {"angle_deg", series([&](double t) { return shank.angle(t) * 180 / std::numbers::pi; })},
         {"moment", series([&](double t) { return shank.moment(t); })},
         {"deviation", series([&](double t) { return 0.1 * std::abs(shank.moment(t)); })},
         {"shares", {{"joint centres", 0.6}, {"masses", 0.3}, {"markers", 0.1}}},
         {"power", series([&](double t) { return shank.power(t); })}});
  }
  efforts["residuals"] = {
      {{"coordinate", "lower_trunk_x"},
       {"unit", "N"},
       {"rms", 12.34},
       {"peak", 61},
       {"percent_of_peak_force", 6.1}},
      {{"coordinate", "lower_trunk_z"},
       {"unit", "N"},
       {"rms", 1.2},
       {"peak", 3.4},
       {"percent_of_peak_force", 0.34}},
      {{"coordinate", "lower_trunk_turn.x"}, {"unit", "N m"}, {"rms", 0.5}, {"peak", 1.5}}};
  efforts["forces"] = {{{"name", "foot_left on plate 1"},
                        {"solid", "foot_left"},
                        {"force", series([](double t) {
                           return json{0, 0, 500 * t};
                         })},
                        {"point", series([](double t) {
                           return t < 0.195 ? json() : json{0.1 * t, 0, 0};
                         })}}};
  return efforts;
}

}  // namespace borelli::test
