// A table over time with named columns: what OpenSim's .mot and .sto files hold.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace borelli {

struct MotionTable {
  std::string name;                  ///< the file's own title
  std::vector<std::string> columns;  ///< without the time
  std::vector<double> times;         ///< s, increasing; one per row
  Eigen::MatrixXd values;            ///< #times by #columns; NaN where the file has no number
  bool in_degrees = false;           ///< whether the file's angles are degrees: values are as in the file
};

}  // namespace borelli
