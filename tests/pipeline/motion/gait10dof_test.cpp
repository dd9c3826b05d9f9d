// A whole case against OpenSim: the walk of gait10dof, which is distributed with OpenSim together with its
// own inverse kinematics and inverse dynamics.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/model_file.hpp"
#include "pipeline/motion/foot_contact.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/recordings/id_setup.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/recording.hpp"
#include "tests/paths.hpp"

namespace borelli::test::gait10dof_test {
namespace {

using Eigen::VectorXd;

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

std::filesystem::path given(const std::string& name) { return shared_folder() + "/motion/gait10dof/" + name; }

struct Walk {
  Scene scene = need(read_model(given("subject01.osim"))).scene;
  System system = need(compile(scene));
};

/// Root mean square and largest difference of a column in two tables, without `ends` rows at each end.
struct Difference {
  double rms = 0, largest = 0;
};
Difference difference(const MotionTable& ours, const MotionTable& theirs, const std::string& name,
                      Eigen::Index ends) {
  const auto column = [&](const MotionTable& table) {
    const auto found = std::find(table.columns.begin(), table.columns.end(), name);
    EXPECT_NE(found, table.columns.end()) << name;
    return table.values.col(found - table.columns.begin())
        .segment(ends, table.values.rows() - 2 * ends)
        .eval();
  };
  const VectorXd d = column(ours) - column(theirs);
  return {std::sqrt(d.squaredNorm() / double(d.size())), d.cwiseAbs().maxCoeff()};
}

TEST(Gait10dof, InverseKinematicsMatchesOpenSim) {
  const Walk walk;
  MotionFitRequest request;
  request.setup = need(read_ik_setup(given("walk_Setup_IK.xml")));
  const Recording recording = need(read_recording(given("subject01_walk.trc")));
  const MotionFit fit = need(fit_motion(walk.scene, walk.system, recording.markers, request));
  ASSERT_EQ(fit.times.size(), 151u);
  const MotionTable ours = table_of(walk.system, fit);
  const MotionTable theirs = need(read_motion_table(given("subject01_walk_IK.mot"))).table;
  for (const CoordinateInfo& c : walk.system.coordinates) {
    const Difference d = difference(ours, theirs, c.name, 0);
    // OpenSim stops at an accuracy of 1e-5; deg, or m
    EXPECT_LT(d.rms, c.angle ? 0.02 : 2e-4) << c.name;
    EXPECT_LT(d.largest, c.angle ? 0.1 : 1e-3) << c.name;
  }
}

TEST(Gait10dof, InverseDynamicsMatchesOpenSim) {
  const Walk walk;
  const InverseDynamicsSetup setup = need(read_id_setup(given("walk_Setup_ID.xml")));
  const TablePositions motion =
      need(positions_in(walk.system, need(read_motion_table(given("subject01_walk_IK.mot"))).table));
  const ExternalLoads loads =
      need(read_external_loads(given("subject01_walk_grf.xml"), given("subject01_walk_grf.mot")));
  MotionEffortsRequest request;
  request.cutoff = *setup.lowpass_cutoff;
  const RecordedEfforts efforts = need(efforts_of(walk.system, motion.positions, loads.loads, request));
  const MotionTable ours = effort_table_of(walk.system, efforts);
  const MotionTable theirs = need(read_motion_table(given("subject01_walk_ID.sto"))).table;
  ASSERT_EQ(ours.times.size(), theirs.times.size());
  for (const std::string& name : ours.columns) {
    const Difference d = difference(ours, theirs, name, 5);
    EXPECT_LT(d.rms, 0.01) << name;  // N m, or N
  }
}

TEST(Gait10dof, FeetAreFoundByContact) {
  const Walk walk;
  const TablePositions motion =
      need(positions_in(walk.system, need(read_motion_table(given("subject01_walk_IK.mot"))).table));
  const RecordedMotion recorded = need(RecordedMotion::of(walk.system, motion.positions, 6));
  const auto forces = need(forces_in(need(read_motion_table(given("subject01_walk_grf.mot"))).table));
  ASSERT_EQ(forces.size(), 2u);
  const FootLoads found = need(loads_on_feet(walk.system, recorded, forces, feet_of(walk.system)));
  ASSERT_EQ(found.loads.size(), 2u);
  // the set-up assigns plates to feet: the first one is under the right foot
  EXPECT_EQ(found.loads[0].body, "calcn_r");
  EXPECT_EQ(found.loads[1].body, "calcn_l");
}

/// The set-up's loads at time t, linear between samples.
std::vector<SolidWrench> wrenches_at(const System& system, const ExternalLoads& loads, double t) {
  std::vector<SolidWrench> out;
  for (const ExternalLoad& load : loads.loads) {
    const MeasuredForce& m = load.measured;
    const auto high =
        std::min(std::size_t(std::upper_bound(m.times.begin(), m.times.end(), t) - m.times.begin()),
                 m.times.size() - 1);
    const auto k = Eigen::Index(high);
    const double share = (t - m.times[high - 1]) / (m.times[high] - m.times[high - 1]);
    const auto between = [&](const Eigen::Matrix3Xd& x) -> Eigen::Vector3d {
      return (1 - share) * x.col(k - 1) + share * x.col(k);
    };
    const int solid =
        int(std::find(system.solids.begin(), system.solids.end(), load.body) - system.solids.begin());
    out.push_back({solid, between(m.force), between(m.point), between(m.moment)});
  }
  return out;
}

TEST(Gait10dof, EffortsReproduceTheMotionForwards) {
  const Walk walk;
  const System& system = walk.system;
  const TablePositions table =
      need(positions_in(system, need(read_motion_table(given("subject01_walk_IK.mot"))).table));
  const ExternalLoads loads =
      need(read_external_loads(given("subject01_walk_grf.xml"), given("subject01_walk_grf.mot")));
  const RecordedMotion motion = need(RecordedMotion::of(system, table.positions, 6));
  MotionEfforts efforts(system);
  State recorded, state;
  VectorXd a;
  const VectorXd none = VectorXd::Zero(system.nv);
  // joint efforts from inverse dynamics of the recorded motion; ground forces act on the actual state
  const auto acceleration = [&](double t, const State& at) -> VectorXd {
    motion.at(t, recorded, a);
    const auto wrenches = wrenches_at(system, loads, t);
    const VectorXd joints = efforts.needed(recorded, a, wrenches);
    const VectorXd without = efforts.needed(at, none, {});
    const VectorXd ground = without - efforts.needed(at, none, wrenches);
    return need(evaluate(system, at, joints + ground)).acceleration;
  };
  const double start = 1, end = 1.5;
  const auto rates = [&](double t, const VectorXd& y) -> VectorXd {
    State at{t, y.head(system.nq), y.tail(system.nv)};
    VectorXd out(y.size());
    out << at.v, acceleration(t, at);  // every coordinate is a scalar
    return out;
  };
  ASSERT_EQ(system.nq, system.nv);
  const auto error = [&](int steps) {  // error of the classical Runge-Kutta method
    motion.at(start, state, a);
    VectorXd y(2 * system.nq);
    y << state.q, state.v;
    const double h = (end - start) / steps;
    for (int i = 0; i < steps; ++i) {
      const double t = start + i * h;
      const VectorXd k1 = rates(t, y), k2 = rates(t + h / 2, y + h / 2 * k1),
                     k3 = rates(t + h / 2, y + h / 2 * k2), k4 = rates(t + h, y + h * k3);
      y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    motion.at(end, recorded, a);
    return (y.head(system.nq) - recorded.q).cwiseAbs().maxCoeff();
  };
  // measured forces on the feet make the body unstable, so that errors grow; the method's order remains
  const double coarse = error(2000), fine = error(4000);
  EXPECT_GT(coarse / fine, 10);  // 2^4
  EXPECT_LT(fine, 1e-4);
}

}  // namespace
}  // namespace borelli::test::gait10dof_test
