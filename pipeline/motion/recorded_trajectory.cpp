#include "pipeline/motion/recorded_trajectory.hpp"

#include "dynamics/equations/evaluate.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

Trajectory posed_trajectory(const System& system, const RecordedPositions& positions) {
  Trajectory out;
  out.times = positions.times;
  out.coordinates = system.coordinates;
  out.q = positions.q;
  out.solids = system.solids;
  SolidPoses poses(system);
  for (std::size_t i = 0; i < out.times.size(); ++i) {
    poses.update(out.times[i], out.q.row(Eigen::Index(i)).transpose());
    for (std::size_t s = 0; s < system.solids.size(); ++s) out.poses.push_back(poses.of(int(s)));
  }
  return out;
}

Result<Trajectory> recorded_trajectory(const System& system, const RecordedEfforts& motion) {
  Trajectory out = posed_trajectory(system, {motion.times, motion.q});
  out.v = motion.v;
  out.a = motion.a;
  const auto count = Eigen::Index(motion.times.size());
  for (Rows* rows : {&out.gravity_centre, &out.linear_momentum, &out.angular_momentum})
    rows->resize(count, 3);
  State state = system.initial;
  Workspace workspace(system);
  for (Eigen::Index i = 0; i < count; ++i) {
    state.t = motion.times[std::size_t(i)];
    state.q = motion.q.row(i).transpose();
    state.v = motion.v.row(i).transpose();
    const auto terms = evaluate(system, state, {}, workspace);
    if (!terms) return tl::unexpected(terms.error());
    out.gravity_centre.row(i) = terms->momenta.centre.transpose();
    out.linear_momentum.row(i) = terms->momenta.linear.transpose();
    out.angular_momentum.row(i) = terms->momenta.angular.transpose();
    out.kinetic.push_back(terms->kinetic_energy);
    out.potential.push_back(terms->potential_energy);
    out.work.push_back(out.kinetic.back() + out.potential.back() - out.kinetic.front() -
                       out.potential.front());
  }
  out.certificate.trusted = true;
  out.certificate.method = captured_method;
  out.certificate.equations = "recursive";
  return out;
}

}  // namespace borelli
