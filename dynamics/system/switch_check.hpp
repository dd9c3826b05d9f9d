// Checks a switch before it is laid out, and fills in missing initial values.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/switch.hpp"
#include "error/error.hpp"

namespace borelli {

/// A checked switch, ready to be laid out.
struct CheckedSwitch {
  SwitchKind kind;        ///< with a unit axis
  std::string kind_name;  ///< as in files
  int nq = 0, nv = 0;     ///< numbers of positions and velocities; 0: no coordinate
  bool rotates = false, slides = false;
  std::vector<double> q, v;  ///< initial, nq and nv numbers; a quaternion made unit
};

/// Errors: an axis without direction, a placement that is not rigid, numbers that are not finite or of the
/// wrong count, a start outside its ranges, unsuitable drive functions, or settings that the switch cannot
/// have. `where` names the switch in errors.
Result<CheckedSwitch> check_switch(const Switch& one, const std::string& where);

/// Checks the ranges of a switch with a coordinate: none, or nv of them, finite, with lower <= upper, that
/// contain its start q (nq numbers; a quaternion unit). A driven switch must have none.
Result<void> check_ranges(const Switch& one, const std::vector<double>& q, const std::string& where);

}  // namespace borelli
