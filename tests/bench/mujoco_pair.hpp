// One model in both engines, borelli's recursive equations and MuJoCo's, at one state.
#pragma once

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "dynamics/equations/batch.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/formats/model_file.hpp"

namespace borelli {

struct MujocoPair {
  System system;
  std::unique_ptr<Workspace> workspace;
  std::unique_ptr<BatchState> eight;
  std::unique_ptr<BatchWorkspace> batch;
  mjModel* model = nullptr;  ///< null where MuJoCo cannot read the file
  mjData* data = nullptr;
  Eigen::VectorXd q, v, a, needed;
  Eigen::VectorX<Lanes> accelerations_of_eight, efforts_of_eight;  ///< the former given, the latter computed
  bool mass_matrices = false;                                      ///< the batch has room for them

  /// Reads an MJCF file; `disabled` are MuJoCo's mjDSBL flags, added to those of the file.
  MujocoPair(const std::string& file, int disabled) {
    auto read = read_model(file);
    if (!read) throw std::runtime_error(read.error().what);
    read->scene.simulation.equations = Equations::recursive;
    auto compiled = compile(read->scene);
    if (!compiled) throw std::runtime_error(compiled.error().what);
    system = std::move(*compiled);
    workspace = std::make_unique<Workspace>(system);
    q = system.initial.q;
    v = system.initial.v;
    a = needed = Eigen::VectorXd::Zero(system.nv);
    workspace->recursion.emplace(system);
    accelerations_of_eight = efforts_of_eight = Eigen::VectorX<Lanes>::Zero(system.nv);
    eight = std::make_unique<BatchState>(system);
    mass_matrices = system.nv <= 100;
    batch = std::make_unique<BatchWorkspace>(system, mass_matrices);
    char error[1000] = "";
    model = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
    if (!model) {
      std::fprintf(stderr, "MuJoCo cannot read %s: %s\n", file.c_str(), error);
    } else {
      model->opt.disableflags |= disabled;
      data = mj_makeData(model);
    }
    set();
  }
  ~MujocoPair() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  MujocoPair(const MujocoPair&) = delete;
  MujocoPair& operator=(const MujocoPair&) = delete;

  /// Copies q, v and a into MuJoCo, and fills the batch with nearby states.
  void set() {
    for (int lane = 0; lane < Lanes::count; ++lane) {
      State state{0, q.array() + 0.1 * lane, v.array() * (1 + 0.1 * lane)};
      for (const CoordinateInfo& c : system.coordinates)
        if (c.q_size == 4) state.q.segment<4>(c.q_index).normalize();
      eight->set(lane, state);
      for (int i = 0; i < system.nv; ++i) accelerations_of_eight[i].set(lane, a[i] * (1 + 0.1 * lane));
    }
    if (!model) return;
    std::copy(q.begin(), q.end(), data->qpos);
    std::copy(v.begin(), v.end(), data->qvel);
    std::copy(a.begin(), a.end(), data->qacc);
  }

  /// Random positions, with velocities up to 1/s and accelerations up to 1/s^2.
  void set_random(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    for (const CoordinateInfo& c : system.coordinates) {
      for (int i = 0; i < c.q_size; ++i) q[c.q_index + i] = number(random);
      if (c.q_size == 4) q.segment<4>(c.q_index).normalize();
    }
    for (double& x : v) x = number(random);
    for (double& x : a) x = number(random);
    set();
  }
};

}  // namespace borelli
