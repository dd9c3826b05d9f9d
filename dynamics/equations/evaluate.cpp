#include "dynamics/equations/evaluate.hpp"

#include <fmt/format.h>

#include "dynamics/system/border.hpp"

namespace borelli {

Result<void> check_state(const System& system, const State& state) {
  if (state.q.size() != system.nq || state.v.size() != system.nv)
    return bad_use("state", fmt::format("has {} positions and {} velocities; the scene has {} and {}",
                                        state.q.size(), state.v.size(), system.nq, system.nv));
  if (!std::isfinite(state.t)) return bad_use("state", "its time is not a finite number");
  for (const CoordinateInfo& info : system.coordinates) {
    const auto q = state.q.segment(info.q_index, info.q_size);
    if (!q.allFinite() || !state.v.segment(info.v_index, info.v_size).allFinite())
      return bad_use(fmt::format("coordinate '{}'", info.name),
                     "its position or velocity is not a finite number");
    if (info.q_size == 4 && std::abs(q.norm() - 1) > 1e-3)
      return bad_use(fmt::format("coordinate '{}'", info.name),
                     fmt::format("its quaternion has length {:.6g}; expected 1", q.norm()));
  }
  return {};
}

std::string violation(const System& system, const Evaluation& evaluated) {
  Eigen::VectorXd size = evaluated.constraint_position.cwiseAbs();
  for (const Contact& contact : system.contacts) size[contact.row] = 0;  // (a gap)
  int worst = -1;
  double most = 1e-6;
  for (int r = 0; r < size.size(); ++r)
    if (const double part = size[r] / system.row_scale[std::size_t(r)]; part > most) worst = r, most = part;
  return worst < 0 ? ""
                   : fmt::format("constraint '{}' is violated by {:.3g}",
                                 system.row_names[std::size_t(worst)], size[worst]);
}

Result<Evaluation> evaluate(const System& system, const State& state, const Eigen::VectorXd& efforts) {
  return at_border(system, [&]() -> Result<Evaluation> {
    // The result holds another mass matrix and copies of the rows.
    if (auto fits = admit_workspaces(system, system.settings.equations, 2, true); !fits)
      return tl::unexpected(fits.error());
    Workspace w(system);
    return evaluate(system, state, efforts, w);
  });
}

Result<Evaluation> evaluate(const System& system, const State& state, const Eigen::VectorXd& efforts,
                            Workspace& w) {
  return at_border(system, [&]() -> Result<Evaluation> {
    if (auto ok = check_state(system, state); !ok) return tl::unexpected(ok.error());
    if (efforts.size() != 0 && efforts.size() != system.nv)
      return bad_use("efforts",
                     fmt::format("have {} entries; the scene has {} velocities", efforts.size(), system.nv));
    const double* applied = efforts.size() ? efforts.data() : nullptr;
    if (const Fault fault =
            accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, w, applied))
      return tl::unexpected(describe(system, fault, state.t));
    const int n = system.nv;
    Evaluation out;
    out.acceleration = w.a;
    out.multipliers = w.multipliers;
    out.drive_efforts = w.drive_efforts;
    // The accelerations may not have needed A, B and Q.
    if (const Fault fault =
            update_unfactored_terms(system, system.parameters, state.t, state.q.data(), state.v.data(), w))
      return tl::unexpected(describe(system, fault, state.t));
    if (applied)
      for (int i = 0; i < n; ++i) w.terms.Q[i] += applied[i];
    out.coordinates = system.velocity_names();
    out.mass_matrix = w.terms.A.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
    out.bias = w.terms.B.head(n);
    out.generalized_efforts = w.terms.Q.head(n);
    out.rows = system.row_names;
    out.constraint_jacobian = w.rows.L.leftCols(n);
    out.constraint_bias = w.rows.E;
    out.constraint_position = w.rows.h;
    out.constraint_rate = w.rows.rate;
    out.kinetic_energy = w.terms.kinetic;
    out.potential_energy = w.terms.potential;
    out.momenta = momenta(system, system.parameters, w.kinematics);
    out.centroidal = centroidal_momentum(system, system.parameters, w.kinematics);
    return out;
  });
}

}  // namespace borelli
