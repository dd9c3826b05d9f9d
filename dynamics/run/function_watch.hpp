// Detects steps that skip a feature of a function of a coordinate or of a curve that guides a point. Example:
// a step that ends on level ground on both sides of a cam's bump leaves no trace in residuals or energy.
#pragma once

#include <string>
#include <vector>

#include "dynamics/equations/kinematics.hpp"

namespace borelli {

class FunctionWatch {
 public:
  /// `allowed`: tolerated deviation of a function from what the step's ends predict, relative to its
  /// constraint's System::row_scale.
  FunctionWatch(const System& system, const Parameters& parameters, double allowed);

  bool empty() const { return watched_.empty(); }
  /// Name of the constraint whose function makes the step from a to b too long; empty: none. The step is too
  /// long if its piece of the function deviates from the quintic through values, slopes and curvatures at
  /// both ends. Pieces within half an interval of a table are always accepted.
  std::string passed_over(const Kinematics& a, const Kinematics& b) const;

 private:
  const System& system_;
  const Parameters& parameters_;
  double allowed_;
  std::vector<std::size_t> watched_;  ///< constraints
};

}  // namespace borelli
