// A model in MuJoCo, and comparison of its equations of motion with ours. Needs MuJoCo (BORELLI_MUJOCO).
#pragma once

#include <mujoco/mujoco.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"

namespace borelli::test {

/// A model that MuJoCo has read from a file, contacts, limits, equalities and actuators switched off.
struct Mujoco {
  mjModel* model = nullptr;
  mjData* data = nullptr;

  explicit Mujoco(const std::filesystem::path& file) {
    char error[1000] = "";
    model = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
    if (!model) throw std::runtime_error(error);
    model->opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_CONTACT | mjDSBL_ACTUATION;
    data = mj_makeData(model);
  }
  /// From the text of a model.
  static Mujoco of(const std::string& xml) {
    const auto path = std::filesystem::temp_directory_path() / fmt::format("borelli_{}.xml", getpid());
    std::ofstream(path) << xml;
    Mujoco out(path);
    std::filesystem::remove(path);
    return out;
  }
  Mujoco(Mujoco&& other) noexcept
      : model(std::exchange(other.model, nullptr)), data(std::exchange(other.data, nullptr)) {}
  ~Mujoco() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  Mujoco(const Mujoco&) = delete;
  Mujoco& operator=(const Mujoco&) = delete;

  /// A, driving efforts (passive + applied - bias) and accelerations at a state, in MuJoCo's order.
  struct Terms {
    Rows A;
    Eigen::VectorXd drive, acceleration;
  };
  Terms at(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Eigen::VectorXd& efforts) {
    std::copy(q.begin(), q.end(), data->qpos);
    std::copy(v.begin(), v.end(), data->qvel);
    std::copy(efforts.begin(), efforts.end(), data->qfrc_applied);
    mj_forward(model, data);
    const int n = model->nv;
    Terms out{Rows(n, n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
    mj_fullM(model, out.A.data(), data->qM);
    for (int i = 0; i < n; ++i) {
      out.drive[i] = data->qfrc_passive[i] + data->qfrc_applied[i] - data->qfrc_bias[i];
      out.acceleration[i] = data->qacc[i];
    }
    return out;
  }
};

/// The largest difference relative to the largest expected entry.
inline double relative_to_largest(const Eigen::MatrixXd& a, const Eigen::MatrixXd& expected) {
  return (a - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

/// Index in the system of each of MuJoCo's positions and velocities; empty: the same index.
struct Order {
  std::vector<Eigen::Index> q, v;
};
/// Indices of MuJoCo's positions and velocities in the system, by joint names.
inline Order order_in(const System& system, const mjModel& model) {
  Order order{std::vector<Eigen::Index>(std::size_t(model.nq)),
              std::vector<Eigen::Index>(std::size_t(model.nv))};
  for (const CoordinateInfo& info : system.coordinates) {
    int id = mj_name2id(&model, mjOBJ_JOINT, info.name.c_str()), q = 0, v = 0;
    if (id < 0) {  // coordinate of a free joint: NAME.x or NAME_x, and so on
      const auto dot = info.name.find_last_of("._");
      id = mj_name2id(&model, mjOBJ_JOINT, info.name.substr(0, dot).c_str());
      const std::string part = info.name.substr(dot + 1);
      q = v = part == "turn" ? 3 : part[0] - 'x';
    }
    if (id < 0) throw std::runtime_error("MuJoCo has no joint " + info.name);
    for (int i = 0; i < info.q_size; ++i)
      order.q[std::size_t(model.jnt_qposadr[id] + q + i)] = info.q_index + i;
    for (int i = 0; i < info.v_size; ++i)
      order.v[std::size_t(model.jnt_dofadr[id] + v + i)] = info.v_index + i;
  }
  return order;
}

struct Differences {
  double A = 0, drive = 0, acceleration = 0;
};
/// The largest relative differences of A, Q - B and the accelerations over random states with random efforts.
inline Differences differences(const System& system, Mujoco& mujoco, unsigned seed = 1, Order order = {}) {
  if (system.nq != mujoco.model->nq || system.nv != mujoco.model->nv)
    throw std::runtime_error(fmt::format("nq, nv are {}, {}; MuJoCo has {}, {}", system.nq, system.nv,
                                         mujoco.model->nq, mujoco.model->nv));
  if (order.q.empty()) {
    for (int i = 0; i < system.nq; ++i) order.q.push_back(i);
    for (int i = 0; i < system.nv; ++i) order.v.push_back(i);
  }
  Random random(seed);
  Differences out;
  for (int trial = 0; trial < 5; ++trial) {
    const State state = random.state(system);
    Eigen::VectorXd efforts(system.nv);
    for (double& e : efforts) e = random.number(-10, 10);
    const Evaluation own = need(evaluate(system, state, efforts));
    const Mujoco::Terms other = mujoco.at(state.q(order.q), state.v(order.v), efforts(order.v));
    out.A = std::max(out.A, relative_to_largest(own.mass_matrix(order.v, order.v), other.A));
    out.drive =
        std::max(out.drive, relative_to_largest((own.generalized_efforts - own.bias)(order.v), other.drive));
    out.acceleration =
        std::max(out.acceleration, relative_to_largest(own.acceleration(order.v), other.acceleration));
  }
  return out;
}

}  // namespace borelli::test
