// Phantoms for the tests of several files, each built once.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "samples/phantom.hpp"

namespace borelli::phantom_test {

inline Phantom built(const PhantomOptions& options = {}) {
  auto phantom = build_phantom(options);
  EXPECT_TRUE(phantom) << phantom.error().message();
  return phantom ? std::move(*phantom) : Phantom{};
}

inline const Phantom& standing_male() {
  static const Phantom phantom = built();
  return phantom;
}

// Bodies at the limits of the options.
inline std::vector<PhantomOptions> options_of_bodies() {
  const std::map<std::string, double> bent{
      {"shoulder_left_flexion", 60},  {"shoulder_right_abduction", 40}, {"elbow_left_flexion", 110},
      {"wrist_left_flexion", 40},     {"wrist_right_flexion", -40},     {"hip_left_flexion", 30},
      {"hip_right_abduction", 15},    {"hip_right_flexion", -10},       {"knee_left_flexion", 80},
      {"ankle_left_dorsiflexion", 5}, {"ankle_right_dorsiflexion", -15}};
  std::vector<PhantomOptions> all{{}, {.mass_kg = 58.5}, {.mass_kg = 91}, {.pose_deg = bent}};
  for (PhantomOptions options : {PhantomOptions{}, {.mass_kg = 50}, {.mass_kg = 77}, {.pose_deg = bent}}) {
    options.sex = Sex::female;
    all.push_back(options);
  }
  return all;
}

inline const std::vector<Phantom>& bodies() {
  static const std::vector<Phantom> all = [] {
    std::vector<Phantom> list;
    for (const PhantomOptions& options : options_of_bodies()) list.push_back(built(options));
    return list;
  }();
  return all;
}

}  // namespace borelli::phantom_test
