// Systems, their states, and the equations of motion at one state.
#include <fmt/core.h>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/constraints/equilibrium.hpp"
#include "dynamics/equations/derivatives.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "python/common.hpp"
#include "python/model.hpp"

namespace borelli::python {
namespace {

py::list coordinates_of(const CompiledScene& s) {
  py::list out;
  for (const CoordinateInfo& c : s.system.coordinates) {
    py::dict one;
    one["name"] = c.name;
    one["kind"] = c.kind;
    one["solid"] = c.solid;
    one["q_index"] = c.q_index;
    one["q_size"] = c.q_size;
    one["v_index"] = c.v_index;
    one["v_size"] = c.v_size;
    one["angle"] = c.angle;
    out.append(one);
  }
  return out;
}

State state_of(const CompiledScene& s, const py::object& q, const py::object& v, const py::object& t) {
  State state = s.system.initial;
  if (!t.is_none()) state.t = t.cast<double>();
  if (!q.is_none()) state.q = vector_of(numbers_of(q, "q"), s.system.nq, "q");
  if (!v.is_none()) state.v = vector_of(numbers_of(v, "v"), s.system.nv, "v");
  return state;
}

void check_fits(const CompiledScene& s, const State& state) { value_or_throw(check_state(s.system, state)); }

Evaluation evaluated(const CompiledScene& s, const State& state, const py::object& efforts) {
  const Eigen::VectorXd applied = optional_vector(efforts, s.system.nv, "efforts");
  return released([&] { return evaluate(s.system, state, applied); });
}

InverseDynamics inverted(const CompiledScene& s, const State& state, const Numbers& a) {
  const Eigen::VectorXd accelerations = vector_of(a, s.system.nv, "a");
  return released([&] { return inverse_dynamics(s.system, state, accelerations); });
}

py::tuple solid_poses_of(const CompiledScene& s, const State& state) {
  check_fits(s, state);
  const auto count = py::ssize_t(s.system.solids.size());
  py::array_t<double> R({count, py::ssize_t(3), py::ssize_t(3)}), p({count, py::ssize_t(3)});
  SolidPoses poses(s.system);
  poses.update(state.t, state.q);
  for (py::ssize_t n = 0; n < count; ++n) {
    const Pose X = poses.of(int(n));
    for (int i = 0; i < 3; ++i) {
      p.mutable_at(n, i) = X.p[i];
      for (int j = 0; j < 3; ++j) R.mutable_at(n, i, j) = X.R(i, j);
    }
  }
  return py::make_tuple(R, p);
}

State assembled(const CompiledScene& s, State state) {
  check_fits(s, state);
  released([&] { return assemble(s.system, state); });
  return state;
}

void set_numbers(Eigen::VectorXd& to, const Numbers& numbers, const char* what) {
  to = vector_of(numbers, to.size(), what);  // the same size: views stay valid
}

void add_state(py::module_& m) {
  py::class_<State, std::shared_ptr<State>>(
      m, "State",
      "Time, positions and velocities of a system's free coordinates. q and v are views: writing to them "
      "changes the state.")
      .def_readwrite("t", &State::t, "Time, s.")
      .def_property(
          "q", [](const py::object& self) { return view(self.cast<State&>().q, self, true); },
          [](State& s, const Numbers& q) { set_numbers(s.q, q, "q"); },
          "Positions, (n_q,): m and rad; of a ball the quaternion (w, x, y, z).")
      .def_property(
          "v", [](const py::object& self) { return view(self.cast<State&>().v, self, true); },
          [](State& s, const Numbers& v) { set_numbers(s.v, v, "v"); },
          "Velocities, (n_v,): m/s and rad/s; of a ball the angular velocity in its own axes.")
      .def(
          "copy", [](const State& s) { return State(s); }, "A state with numbers of its own.")
      .def("__repr__", [](const State& s) {
        return fmt::format("<borelli.State at {} s, {} positions, {} velocities>", s.t, s.q.size(),
                           s.v.size());
      });
}

void add_evaluation(py::module_& m) {
  using E = Evaluation;
  py::class_<E>(m, "Evaluation",
                "The equations at one state, A a + B = Q + L^T lambda and L a + E = 0. Arrays are views.")
      .def_readonly("names", &E::coordinates, "One name per velocity; a ball's three end in .x, .y, .z.")
      .def_property_readonly("acceleration", view_of(&E::acceleration), "a, (n_v,), m/s^2 or rad/s^2.")
      .def_property_readonly("mass_matrix", view_of(&E::mass_matrix), "A, (n_v, n_v).")
      .def_property_readonly("bias", view_of(&E::bias), "B, (n_v,): velocity terms and driven accelerations.")
      .def_property_readonly("generalized_efforts", view_of(&E::generalized_efforts),
                             "Q, (n_v,): weight, springs, dampers and given forces, N or N m.")
      .def_readonly("rows", &E::rows, "Names of the constraint rows.")
      .def_property_readonly("constraint_jacobian", view_of(&E::constraint_jacobian), "L, (rows, n_v).")
      .def_property_readonly("constraint_bias", view_of(&E::constraint_bias), "E, (rows,).")
      .def_property_readonly("constraint_position", view_of(&E::constraint_position),
                             "h, (rows,): the residual of each row, m or rad.")
      .def_property_readonly("constraint_rate", view_of(&E::constraint_rate), "dh/dt, (rows,).")
      .def_property_readonly("multipliers", view_of(&E::multipliers), "lambda, (rows,), N or N m.")
      .def_property_readonly("drive_efforts", view_of(&E::drive_efforts),
                             "Forces of the driven coordinates, N or N m.")
      .def_readonly("kinetic_energy", &E::kinetic_energy, "J.")
      .def_readonly("potential_energy", &E::potential_energy, "J: weight and springs.")
      .def_property_readonly(
          "mass", [](const E& e) { return e.momenta.mass; }, "Of all moving solids, kg.")
      .def_property_readonly(
          "gravity_centre", [](const E& e) { return copy(e.momenta.centre); }, "World, (3,), m.")
      .def_property_readonly(
          "linear_momentum", [](const E& e) { return copy(e.momenta.linear); }, "World, (3,), kg m/s.")
      .def_property_readonly(
          "angular_momentum", [](const E& e) { return copy(e.momenta.angular); },
          "About the gravity centre, world axes, (3,), kg m^2/s.")
      .def_property_readonly(
          "centroidal_momentum_matrix",
          [](const py::object& self) { return view(self.cast<const E&>().centroidal.matrix, self); },
          "(6, n_v): angular rows about the gravity centre, then linear, world axes.");
}

void add_derivatives(py::module_& m) {
  using D = ForwardDerivatives;
  py::class_<D>(m, "Derivatives",
                "Derivatives of accelerations and multipliers, exact to rounding. By q: for a ball by small "
                "rotations about its own axes. Arrays are views.")
      .def_property_readonly("acceleration_by_q", view_of(&D::acceleration_by_q), "(n_v, n_v).")
      .def_property_readonly("acceleration_by_v", view_of(&D::acceleration_by_v), "(n_v, n_v).")
      .def_property_readonly("acceleration_by_efforts", view_of(&D::acceleration_by_efforts), "(n_v, n_v).")
      .def_property_readonly("acceleration_by_inertia", view_of(&D::acceleration_by_inertia),
                             "(n_v, 10 bodies): per body mass, centre x y z, tensor xx yy zz xy xz yz.")
      .def_property_readonly("multipliers_by_q", view_of(&D::multipliers_by_q), "(rows, n_v).")
      .def_property_readonly("multipliers_by_v", view_of(&D::multipliers_by_v), "(rows, n_v).")
      .def_property_readonly("multipliers_by_efforts", view_of(&D::multipliers_by_efforts), "(rows, n_v).")
      .def_readonly("bodies", &D::inertials, "Bodies with mass, each named after its first solid.");
  using I = InverseDynamics;
  py::class_<I>(m, "InverseDynamics", "tau = A a + B - Q and its derivatives. Arrays are views.")
      .def_property_readonly("efforts", view_of(&I::efforts), "tau, (n_v,), N or N m.")
      .def_property_readonly("efforts_by_q", view_of(&I::efforts_by_q), "(n_v, n_v).")
      .def_property_readonly("efforts_by_v", view_of(&I::efforts_by_v), "(n_v, n_v).")
      .def_property_readonly("efforts_by_a", view_of(&I::efforts_by_a), "(n_v, n_v): the mass matrix.")
      .def_property_readonly("efforts_by_inertia", view_of(&I::efforts_by_inertia), "(n_v, 10 bodies).")
      .def_readonly("bodies", &I::inertials, "Bodies with mass, each named after its first solid.");
}

using SystemClass = py::class_<CompiledScene, std::shared_ptr<CompiledScene>>;

void define_names(SystemClass& system) {
  system
      .def_property_readonly(
          "n_q", [](const CompiledScene& s) { return s.system.nq; }, "Number of positions.")
      .def_property_readonly(
          "n_v", [](const CompiledScene& s) { return s.system.nv; }, "Number of velocities.")
      .def_property_readonly(
          "names", [](const CompiledScene& s) { return s.system.velocity_names(); },
          "One name per velocity; a ball's three end in .x, .y, .z.")
      .def_property_readonly("coordinates", &coordinates_of,
                             "The free coordinates: name, kind, solid, and their places in q and v.")
      .def_property_readonly(
          "solids", [](const CompiledScene& s) { return s.system.solids; },
          "Names of the solids, in the scene's order.")
      .def_property_readonly(
          "rows", [](const CompiledScene& s) { return s.system.row_names; }, "Names of the constraint rows.");
}

void define_states(SystemClass& system) {
  system
      .def("state", &state_of, py::arg("q") = py::none(), py::arg("v") = py::none(),
           py::arg("t") = py::none(),
           "A state; what is not given is the scene's initial value. q: (n_q,), v: (n_v,), t: s.")
      .def("assemble", &assembled, py::arg("state"),
           "The state moved onto the constraints, with the least change. Raises Error if they contradict.")
      .def(
          "equilibrium",
          [](const CompiledScene& s, const State& start) {
            check_fits(s, start);
            return released([&] { return find_equilibrium(s.system, start); }).state;
          },
          py::arg("start"), "The state of rest that Newton's method finds from the positions of `start`.")
      .def("poses", &solid_poses_of, py::arg("state"),
           "Rotations (solids, 3, 3), whose columns are the solids' axes in the world, and origins (solids, "
           "3), m.");
}

void define_terms(SystemClass& system) {
  const auto efforts = py::arg("efforts") = py::none();
  system
      .def(
          "evaluate", &evaluated, py::arg("state"), efforts,
          "Everything at one state, which is not assembled. efforts: (n_v,), added to the scene's, N or N m.")
      .def(
          "accelerations",
          [](const CompiledScene& s, const State& state, const py::object& given) {
            return copy(evaluated(s, state, given).acceleration);
          },
          py::arg("state"), efforts, "Accelerations, (n_v,), m/s^2 or rad/s^2.")
      .def(
          "mass_matrix",
          [](const CompiledScene& s, const State& state) {
            return copy(evaluated(s, state, py::none()).mass_matrix);
          },
          py::arg("state"), "A, (n_v, n_v), kg, kg m or kg m^2.")
      .def(
          "bias",
          [](const CompiledScene& s, const State& state) {
            return copy(evaluated(s, state, py::none()).bias);
          },
          py::arg("state"), "B, (n_v,), of A a + B = Q + L^T lambda.")
      .def(
          "energy",
          [](const CompiledScene& s, const State& state) {
            const Evaluation e = evaluated(s, state, py::none());
            return py::make_tuple(e.kinetic_energy, e.potential_energy);
          },
          py::arg("state"), "Kinetic and potential energy (weight and springs), J.");
}

void define_inverse_and_derivatives(SystemClass& system) {
  system
      .def(
          "inverse_dynamics",
          [](const CompiledScene& s, const State& state, const Numbers& a) {
            return copy(inverted(s, state, a).efforts);
          },
          py::arg("state"), py::arg("a"),
          "The forces that accelerations a, (n_v,), need beyond the scene's own: A a + B - Q, (n_v,), N or N "
          "m. "
          "Constraints are left out.")
      .def("inverse_dynamics_derivatives", &inverted, py::arg("state"), py::arg("a"),
           "The same with its derivatives by q, v, a and the inertias.")
      .def(
          "derivatives",
          [](const CompiledScene& s, const State& state, const py::object& given) {
            const Eigen::VectorXd applied = optional_vector(given, s.system.nv, "efforts");
            return released([&] { return forward_derivatives(s.system, state, applied); });
          },
          py::arg("state"), py::arg("efforts") = py::none(),
          "Derivatives of the accelerations by q, v, efforts and inertias.");
}

}  // namespace

void add_equations(py::module_& m) {
  add_state(m);
  add_evaluation(m);
  add_derivatives(m);
  SystemClass system(
      m, "System",
      "A compiled scene: its equations of motion. It is constant; threads may share it. Methods release the "
      "GIL. Coordinates have the order of `coordinates`.");
  system.def(py::init([](const std::shared_ptr<ModelFile>& scene) {
               return std::const_pointer_cast<CompiledScene>(compiled(std::make_shared<ModelFile>(*scene)));
             }),
             py::arg("scene").none(false),
             "Compiles a scene. Raises Error that names the wrong solid, joint or constraint.");
  define_names(system);
  define_states(system);
  define_terms(system);
  define_inverse_and_derivatives(system);
  system.def("__repr__", [](const CompiledScene& s) {
    return fmt::format("<borelli.System '{}', {} positions, {} velocities, {} constraint rows>",
                       s.system.scene, s.system.nq, s.system.nv, s.system.rows);
  });
}

}  // namespace borelli::python
