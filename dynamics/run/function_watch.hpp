// Tells when a step passes over a feature of a function of a coordinate, or of a curve that a point stays on:
// a cam's bump between two states of the step that both lie on level ground leaves no trace in residuals or
// energy.
#pragma once

#include <string>
#include <vector>

#include "dynamics/equations/kinematics.hpp"

namespace borelli {

class FunctionWatch {
 public:
  /// `allowed`: how far a function may be from what the step's ends tell of it, in parts of its constraint's
  /// System::row_scale.
  FunctionWatch(const System& system, const Parameters& parameters, double allowed);

  bool empty() const { return watched_.empty(); }
  /// The constraint whose function the step from a to b is too long for: over the piece that the step
  /// passes, it is not the polynomial of degree 5 through its values, slopes and curvatures at both ends, and
  /// the piece is longer than half an interval of its table. Empty: none.
  std::string passed_over(const Kinematics& a, const Kinematics& b) const;

 private:
  const System& system_;
  const Parameters& parameters_;
  double allowed_;
  std::vector<std::size_t> watched_;  ///< constraints
};

}  // namespace borelli
