// Balls that a writer replaces by three hinges, and the conversion of such a model's states to its scene's.
#pragma once

#include <map>
#include <string>

#include "scenes.hpp"

namespace borelli::test {

/// A ball as three hinges in turn, R = R_x(a) R_y(b) R_z(c), at angles and rates: its quaternion, the map J
/// from rates to its angular velocity in its own axes, and the rate of that map times the rates.
///
/// w = R_z^T R_y^T x a' + R_z^T y b' + z c'. With u' = 0, the rate of R_z^T u is -c' z x R_z^T u.
struct ThreeHinges {
  Quaternion q;
  Matrix3d J;
  Vector3d bend;

  ThreeHinges(const Vector3d& angle, const Vector3d& rate) {
    const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
    const Matrix3d Ry = rotation_about(y, angle[1]), Rz = rotation_about(z, angle[2]);
    q = quaternion(rotation_about(x, angle[0]) * Ry * Rz);
    J.col(0) = Rz.transpose() * Ry.transpose() * x;
    J.col(1) = Rz.transpose() * y;
    J.col(2) = z;
    bend = rate[0] * (-rate[2] * z.cross(J.col(0)) +
                      Rz.transpose() * Vector3d(-rate[1] * y.cross(Ry.transpose() * x))) +
           rate[1] * (-rate[2] * z.cross(J.col(1)));
  }
};

/// Converts a state of the written model to one of the scene: v = J v', and bend = J' v'. The hinges of a
/// ball are called NAME, `separator` and x, y or z.
struct AsScene {
  State state;
  Eigen::MatrixXd J;
  Eigen::VectorXd bend;

  AsScene(const System& scene, const System& written, const State& at, const std::string& separator)
      : state{.t = 0, .q = Eigen::VectorXd(scene.nq), .v = {}},
        J(Eigen::MatrixXd::Zero(scene.nv, written.nv)),
        bend(Eigen::VectorXd::Zero(scene.nv)) {
    std::map<std::string, const CoordinateInfo*> known;
    for (const CoordinateInfo& info : written.coordinates) known[info.name] = &info;
    for (const CoordinateInfo& info : scene.coordinates) {
      if (const auto same = known.find(info.name); same != known.end()) {
        state.q.segment(info.q_index, info.q_size) = at.q.segment(same->second->q_index, info.q_size);
        J.block(info.v_index, same->second->v_index, info.v_size, info.v_size).setIdentity();
        continue;
      }
      Vector3d angle, rate;
      int columns[3];
      for (int i = 0; i < 3; ++i) {
        const CoordinateInfo& hinge = *known.at(info.name + separator + "xyz"[i]);
        columns[i] = hinge.v_index;
        angle[i] = at.q[hinge.q_index], rate[i] = at.v[hinge.v_index];
      }
      const ThreeHinges turn(angle, rate);
      state.q.segment<4>(info.q_index) = turn.q;
      for (int i = 0; i < 3; ++i) J.block<3, 1>(info.v_index, columns[i]) = turn.J.col(i);
      bend.segment<3>(info.v_index) = turn.bend;
    }
    state.v = J * at.v;
  }
};

}  // namespace borelli::test
