#include "dynamics/scene/free_joint.hpp"

namespace borelli {

std::vector<Switch> free_joint(const std::string& name, const Pose& X_PS) {
  std::vector<Switch> out;
  for (int i = 0; i < 3; ++i) {
    Switch& slide = out.emplace_back();
    slide.kind = Translation{Eigen::Vector3d::Unit(i)};
    slide.coordinate = name + "." + "xyz"[i];
    slide.q = {X_PS.p[i]};
  }
  Switch& ball = out.emplace_back();
  ball.kind = Ball{};
  ball.coordinate = name + ".turn";
  const Quaternion q = quaternion(X_PS.R);
  ball.q = {q[0], q[1], q[2], q[3]};
  return out;
}

}  // namespace borelli
