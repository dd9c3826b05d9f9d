// Bindings of simulation: one motion or many, and their results.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "dynamics/contacts/pass_through.hpp"
#include "dynamics/equations/reaction.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/ensemble.hpp"
#include "dynamics/run/simulate.hpp"
#include "error/file_ending.hpp"
#include "error/json_text.hpp"
#include "pipeline/export/certificate_report.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/report/scene_meshes.hpp"
#include "python/common.hpp"
#include "python/model.hpp"

namespace borelli::python {
namespace {

// A trajectory and the scene, with the settings, that it is a motion of.
struct Motion {
  Trajectory trajectory;
  Scene scene;
};

std::shared_ptr<const CompiledScene> system_of(const py::object& scene_or_system) {
  if (py::isinstance<CompiledScene>(scene_or_system))
    return scene_or_system.cast<std::shared_ptr<CompiledScene>>();
  return compiled(std::make_shared<ModelFile>(
      object_of<ModelFile>(scene_or_system, "a borelli.Scene or a borelli.System")));
}

// Takes a keyword out of `options`; None counts as not given.
template <class T>
std::optional<T> taken(py::dict& options, const char* name) {
  if (!options.contains(name)) return std::nullopt;
  const py::object value = options.attr("pop")(name);
  if (value.is_none()) return std::nullopt;
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    refuse(name, std::is_same_v<T, std::string> ? "is not a text"
                 : std::is_same_v<T, bool>      ? "is neither True nor False"
                                                : "is not a number");
  }
}

template <class Choice>
void choose(py::dict& options, const char* name, std::initializer_list<std::pair<const char*, Choice>> known,
            Choice& to) {
  const auto asked = taken<std::string>(options, name);
  if (!asked) return;
  std::string names;
  for (const auto& [word, choice] : known) {
    if (*asked == word) {
      to = choice;
      return;
    }
    names += fmt::format("{}{}", names.empty() ? "" : " or ", word);
  }
  refuse(name, fmt::format("is '{}'; expected {}", *asked, names));
}

// The scene's settings with those of the keywords. What would have no effect is refused, as by the program.
SimulationSettings settings_with(SimulationSettings s, double start, py::dict options) {
  const auto method = taken<std::string>(options, "method");
  const auto accuracy = taken<double>(options, "accuracy"), tolerance = taken<double>(options, "tolerance");
  if (accuracy && (method || tolerance))
    refuse("accuracy", "chooses method and tolerance itself; leave it or them out");
  s.method = method.value_or(s.method);
  s.tolerance = tolerance.value_or(s.tolerance);
  s.accuracy = accuracy.value_or(method || tolerance ? 0 : s.accuracy);
  if (tolerance && !method_is_adaptive(s.method))
    refuse("tolerance", "has no effect with " + s.method + ", whose steps have a fixed length; give step");
  s.step = taken<double>(options, "step").value_or(s.step);
  if (const auto verify = taken<bool>(options, "verify")) s.verify = *verify;
  if (s.verify && s.accuracy == 0) refuse("verify", "has no effect without accuracy");
  s.output_interval = taken<double>(options, "output_interval").value_or(s.output_interval);
  s.rest_speed = taken<double>(options, "rest_speed").value_or(s.rest_speed);
  choose(options, "equations", {{"recursive", Equations::recursive}, {"lagrange", Equations::lagrange}},
         s.equations);
  choose(options, "constraints",
         {{"projection", ConstraintTreatment::projection}, {"baumgarte", ConstraintTreatment::baumgarte}},
         s.constraints);
  choose(options, "impacts",
         {{"sequential", ImpactLaw::sequential}, {"simultaneous", ImpactLaw::simultaneous}}, s.impacts);
  choose(options, "restitution", {{"newton", RestitutionLaw::newton}, {"poisson", RestitutionLaw::poisson}},
         s.restitution);
  if (const auto duration = taken<double>(options, "duration")) s.end_time = start + *duration;
  for (const auto& [name, value] : options)
    refuse(name.cast<std::string>(),
           "is not an option; known: accuracy, constraints, duration, equations, impacts, method, "
           "output_interval, "
           "rest_speed, restitution, step, tolerance, verify");
  return s;
}

std::shared_ptr<Motion> run_simulation(const py::object& scene_or_system, const py::object& state,
                                       bool reactions, py::object callback, const py::kwargs& options) {
  const auto given = system_of(scene_or_system);
  const State start = state.is_none() ? given->system.initial : object_of<State>(state, "a borelli.State");
  const Scene& scene = given->model->scene;
  const SimulationSettings settings = settings_with(given->system.settings, start.t, py::dict(options));
  Watch watch(std::move(callback));
  Observer observer;
  observer.progress = [&](double t) { return watch.goes_on(t); };
  auto motion = std::make_shared<Motion>();
  motion->scene = scene;
  motion->scene.simulation = settings;
  try {
    motion->trajectory = released([&] {
      auto made = simulate(given->system, start, settings, observer);
      if (!made) return made;
      judge_passing(given->model->without_contact, *made);
      if (reactions)
        if (const auto done = add_reactions(scene, *made); !done) made = tl::unexpected(done.error());
      return made;
    });
  } catch (const Failure&) {
    watch.raise();  // what stopped the run comes first
    throw;
  }
  watch.raise();
  const Certificate& certificate = motion->trajectory.certificate;
  if (!certificate.trusted)
    warn({fmt::format("{}: the certificate does not trust the run: {}", scene.name, certificate.reason)});
  return motion;
}

std::shared_ptr<Motion> read_motion(const py::object& path) {
  StoredTrajectory stored = value_or_throw(read_trajectory(path_of(path)));
  auto motion = std::make_shared<Motion>();
  motion->scene = value_or_throw(parse_scene(stored.scene, path_of(path)));
  motion->trajectory = std::move(stored.trajectory);
  return motion;
}

void write_motion(const Motion& motion, const py::object& path) {
  const std::filesystem::path file = path_of(path);
  const std::string ending = ending_of(file);
  if (ending == ".glb" || ending == ".html") {
    const auto made = ending == ".glb" ? scene_glb(motion.scene, motion.trajectory)
                                       : scene_page(motion.scene, motion.trajectory);
    return value_or_throw(write_whole(file, value_or_throw(made)));
  }
  value_or_throw(expect_ending(file.string(), {".h5", ".hdf5", ".csv", ".glb", ".html"}));
  const std::string text = value_or_throw(write_scene(motion.scene));
  value_or_throw(write_whole(file, [&](const std::filesystem::path& part) {
    return write_trajectory(motion.trajectory, text, part);
  }));
}

// Poses lie one after the other: nine numbers of the rotation, by columns, and three of the origin.
static_assert(sizeof(Pose) == 12 * sizeof(double));
py::array poses_view(const py::object& self, bool rotations) {
  const Trajectory& t = self.cast<const Motion&>().trajectory;
  const auto times = py::ssize_t(t.times.size()), solids = py::ssize_t(t.solids.size());
  constexpr py::ssize_t number = sizeof(double), pose = sizeof(Pose);
  const double* const R = t.poses.empty() ? nullptr : t.poses[0].R.data();
  if (rotations) return view(R, {times, solids, 3, 3}, {solids * pose, pose, number, 3 * number}, self);
  return view(t.poses.empty() ? nullptr : t.poses[0].p.data(), {times, solids, 3},
              {solids * pose, pose, number}, self);
}

template <class Member>
auto column(Member Trajectory::*member) {
  return
      [member](const py::object& self) { return view(self.cast<const Motion&>().trajectory.*member, self); };
}
template <auto member>
std::vector<std::string> names_of(const Motion& motion) {
  return motion.trajectory.*member;
}

py::object certificate_of(const Motion& motion) {
  const std::string text = json_text(json_of(motion.trajectory.certificate), -1);
  return py::module_::import("json").attr("loads")(text);
}

void add_trajectory(py::module_& m) {
  using T = Trajectory;
  py::class_<Motion, std::shared_ptr<Motion>>(m, "Trajectory",
                                              "A motion: one row per output time. Arrays are read-only views "
                                              "without copies; World axes, SI units. In a "
                                              "notebook it shows itself moving.")
      .def_property_readonly("times", column(&T::times), "(T,), s; the first is the start.")
      .def_property_readonly("q", column(&T::q), "Positions, (T, n_q).")
      .def_property_readonly("v", column(&T::v), "Velocities, (T, n_v).")
      .def_property_readonly("a", column(&T::a), "Accelerations, (T, n_v).")
      .def_property_readonly("solids", &names_of<&T::solids>, "Names of the solids, in the scene's order.")
      .def_property_readonly(
          "positions", [](const py::object& self) { return poses_view(self, false); },
          "Origins of the solids' frames, (T, solids, 3), m.")
      .def_property_readonly(
          "rotations", [](const py::object& self) { return poses_view(self, true); },
          "(T, solids, 3, 3); columns are the solid's axes in the world.")
      .def_property_readonly("gravity_centre", column(&T::gravity_centre), "(T, 3), m, of all moving solids.")
      .def_property_readonly("linear_momentum", column(&T::linear_momentum), "(T, 3), kg m/s.")
      .def_property_readonly("angular_momentum", column(&T::angular_momentum),
                             "(T, 3), about the gravity centre, kg m^2/s.")
      .def_property_readonly("multiplier_names", &names_of<&T::multiplier_names>, "One per constraint row.")
      .def_property_readonly("multipliers", column(&T::multipliers),
                             "Constraint forces, (T, rows), N or N m.")
      .def_property_readonly("contact_names", &names_of<&T::contact_names>, "One per contact.")
      .def_property_readonly("contact_forces", column(&T::contact_forces), "Normal forces, (T, contacts), N.")
      .def_property_readonly("reaction_forces", column(&T::reaction_forces),
                             "Of the parent on each solid, (T, 3 solids), N; empty unless asked for.")
      .def_property_readonly("reaction_moments", column(&T::reaction_moments),
                             "(T, 3 solids), N m, about reaction_points; empty unless asked for.")
      .def_property_readonly("reaction_points", column(&T::reaction_points), "(T, 3 solids), m.")
      .def_property_readonly("kinetic", column(&T::kinetic), "Kinetic energy, (T,), J.")
      .def_property_readonly("potential", column(&T::potential), "Weight and springs, (T,), J.")
      .def_property_readonly("work", column(&T::work),
                             "Work of what has no potential since the start, (T,), J.")
      .def_property_readonly("step_times", column(&T::step_times), "Start of each accepted step, s.")
      .def_property_readonly("step_sizes", column(&T::step_sizes), "s.")
      .def_property_readonly(
          "trusted", [](const Motion& s) { return s.trajectory.certificate.trusted; },
          "Whether the certificate trusts the run.")
      .def_property_readonly("certificate", &certificate_of,
                             "How far the run can be trusted: every field by name, SI units.")
      .def_property_readonly(
          "summary", [](const Motion& s) { return text_of(s.trajectory.certificate); },
          "The certificate in words.")
      .def(
          "page", [](const Motion& s) { return value_or_throw(scene_page(s.scene, s.trajectory)); },
          "The moving scene as one HTML page. Rows 1/60 s apart (output_interval) look smooth.")
      .def("write", &write_motion, py::arg("path"),
           "Writes the motion as .h5 (complete), .csv, .glb or .html, as `borelli simulate -o` does.")
      .def("__len__", [](const Motion& s) { return s.trajectory.times.size(); })
      .def("__repr__",
           [](const Motion& s) {
             return fmt::format("<borelli.Trajectory of '{}', {} rows, {}>", s.scene.name,
                                s.trajectory.times.size(),
                                s.trajectory.certificate.trusted ? "trusted" : "not trusted");
           })
      .def("_repr_html_",
           [](const Motion& s) { return framed(value_or_throw(scene_page(s.scene, s.trajectory)), 600); });
  m.def("read_trajectory", &read_motion, py::arg("path"),
        "Reads a trajectory that Trajectory.write or `borelli simulate -o` wrote as .h5.");
}

// Endings of an ensemble as arrays.
struct Endings {
  Rows q, v;
  Eigen::VectorXd energy_drift;
  std::vector<bool> trusted;
  std::vector<std::string> reasons;
  std::vector<long> steps;
};

Rows member_rows(const py::object& given, Eigen::Index count, const Eigen::VectorXd& standard,
                 const std::string& what) {
  if (given.is_none()) return standard.transpose().replicate(count, 1);
  const Numbers numbers = numbers_of(given, what);
  if (numbers.ndim() != 2 || numbers.shape(0) != count || numbers.shape(1) != standard.size())
    refuse(what, fmt::format("does not have the shape ({}, {})", count, standard.size()));
  return Eigen::Map<const Rows>(numbers.data(), count, standard.size());
}

Eigen::Index members_of(std::initializer_list<py::object> given) {
  for (const py::object& one : given)
    if (!one.is_none()) return py::len(one);
  refuse("q", "is missing; give q, v or efforts with one row per member");
}

Endings run_ensemble(const py::object& scene_or_system, const py::object& q, const py::object& v,
                     const py::object& efforts, int threads, py::object callback, const py::kwargs& options) {
  const auto given = system_of(scene_or_system);
  const System& system = given->system;
  const State& start = system.initial;
  const Eigen::Index count = members_of({q, v, efforts});
  const Rows all_q = member_rows(q, count, start.q, "q"), all_v = member_rows(v, count, start.v, "v");
  const Rows all_efforts = member_rows(efforts, count, Eigen::VectorXd::Zero(system.nv), "efforts");
  const SimulationSettings settings = settings_with(system.settings, start.t, py::dict(options));
  std::vector<Member> members(static_cast<std::size_t>(count));
  for (Eigen::Index n = 0; n < count; ++n) {
    Member& member = members[static_cast<std::size_t>(n)];
    member.start = {start.t, all_q.row(n), all_v.row(n)};
    if (!efforts.is_none()) member.efforts = all_efforts.row(n);
  }
  Watch watch(std::move(callback));
  const auto made = released([&] {
    return simulate_ensemble(system, members, settings, threads,
                             [&](std::size_t n) { return watch.goes_on(n); });
  });
  watch.raise();
  Endings out{Rows::Constant(count, system.nq, NAN),
              Rows::Constant(count, system.nv, NAN),
              Eigen::VectorXd(count),
              {},
              {},
              {}};
  for (Eigen::Index n = 0; n < count; ++n) {
    const Ending& one = made[static_cast<std::size_t>(n)];
    if (one.state.q.size() > 0) out.q.row(n) = one.state.q, out.v.row(n) = one.state.v;
    out.energy_drift[n] = one.energy_drift;
    out.trusted.push_back(one.trusted);
    out.reasons.push_back(one.reason);
    out.steps.push_back(one.steps);
  }
  return out;
}

}  // namespace

void add_simulation(py::module_& m) {
  add_trajectory(m);
  m.def("methods", &integrator_names, "Names of the integrators.");
  m.def(
      "simulate", &run_simulation, py::arg("scene"), py::kw_only(), py::arg("state") = py::none(),
      py::arg("reactions") = false, py::arg("callback") = py::none(),
      "Simulates a Scene or a System from `state` (default: the scene's), first assembled on its "
      "constraints.\n\n"
      "duration: s; accuracy: wanted error of the state relative to its scales, 1e-11 to 0.1; or method and\n"
      "tolerance or step (s); output_interval: s between rows, 0: every step; equations: 'recursive' or\n"
      "'lagrange'; constraints: 'projection' or 'baumgarte'; impacts: 'sequential' or 'simultaneous';\n"
      "restitution: 'newton' or 'poisson'; rest_speed: m/s; verify: repeat at a tenth of the tolerance.\n"
      "What is not given is the scene's setting.\n\n"
      "reactions: also find the joint reactions. callback(t): called after each step with the time reached, "
      "s;\n"
      "False stops the run, whose rows so far are returned.\n\n"
      "The GIL is released. A run that cannot be trusted is a DoubtWarning; one that cannot be continued an "
      "Error.");
  py::class_<Endings>(m, "Ensemble", "The ends of many motions, one row per member. Arrays are views.")
      .def_property_readonly("q", view_of(&Endings::q), "(N, n_q); NaN where a motion did not reach its end.")
      .def_property_readonly("v", view_of(&Endings::v), "(N, n_v); NaN where a motion did not reach its end.")
      .def_property_readonly("energy_drift", view_of(&Endings::energy_drift), "(N,), over the turnover.")
      .def_property_readonly(
          "trusted", [](const Endings& e) { return py::array(py::cast(e.trusted)); }, "(N,), bool.")
      .def_property_readonly(
          "steps", [](const Endings& e) { return py::array(py::cast(e.steps)); }, "Accepted steps, (N,).")
      .def_readonly("reasons", &Endings::reasons, "Why a member is not trusted; '' if it is.");
  m.def("simulate_ensemble", &run_ensemble, py::arg("scene"), py::arg("q") = py::none(),
        py::arg("v") = py::none(), py::kw_only(), py::arg("efforts") = py::none(), py::arg("threads") = 0,
        py::arg("callback") = py::none(),
        "Simulates many motions of one scene, eight side by side on each core.\n\n"
        "q: (N, n_q), v: (N, n_v), efforts: (N, n_v) constant forces in N or N m; what is not given is the\n"
        "scene's. Options as of simulate, without accuracy and output_interval. threads: 0: all.\n"
        "callback(made): the number of finished motions; False stops.");
}

}  // namespace borelli::python
