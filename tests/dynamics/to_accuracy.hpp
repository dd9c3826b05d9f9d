// Settings of runs to a given accuracy.
#pragma once

#include <string>

#include "scenes.hpp"

namespace borelli::test {

inline SimulationSettings to_accuracy(double end, double accuracy, bool verify = false) {
  SimulationSettings out = settings("euler", end, 0.01);  // ignored, as the accuracy chooses both
  out.accuracy = accuracy;
  out.verify = verify;
  return out;
}

inline std::string notes_of(const Certificate& certificate) {
  std::string out;
  for (const std::string& note : certificate.notes) out += note + '\n';
  return out;
}

}  // namespace borelli::test
