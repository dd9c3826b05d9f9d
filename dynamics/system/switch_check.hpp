// What must hold of a switch before it is laid out, and of its numbers where its file or program left them
// out.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/switch.hpp"
#include "error/error.hpp"

namespace borelli {

/// A switch that can be laid out.
struct CheckedSwitch {
  SwitchKind kind;        ///< its axis made unit
  std::string kind_name;  ///< as in files
  int nq = 0, nv = 0;     ///< numbers of its position and velocity; 0: it has no coordinate
  bool rotates = false, slides = false;
  std::vector<double> q, v;  ///< initial, nq and nv numbers; a quaternion made unit
};

/// Fails where an axis has no direction, a placement is not rigid, numbers are not finite or not of the right
/// count, a start lies outside its ranges, a drive's functions do not fit, or a switch is given what it
/// cannot have. `where` names the switch in errors.
Result<CheckedSwitch> check_switch(const Switch& one, const std::string& where);

/// Fails unless a switch with a coordinate has nv ranges or none, all finite, none upside down, and unless
/// its start q (nq numbers; a quaternion unit) lies in them; a driven one must have none.
Result<void> check_ranges(const Switch& one, const std::vector<double>& q, const std::string& where);

}  // namespace borelli
