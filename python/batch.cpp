// The equations at many states at once: eight side by side in the lanes of a batch, or one by one for scenes
// that batches refuse. Threads share the states.
#include "dynamics/equations/batch.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "dynamics/equations/evaluate.hpp"
#include "python/common.hpp"
#include "python/model.hpp"
#include "threads/slabs.hpp"

namespace borelli::python {
namespace {

constexpr py::ssize_t lanes = Lanes::count;

// Rows of numbers that Python holds, (N, width).
struct GivenRows {
  const double* data = nullptr;
  Eigen::Index width = 0;
  Eigen::VectorXd row(py::ssize_t n) const {
    return Eigen::Map<const Eigen::VectorXd>(data + n * width, width);
  }
};

GivenRows given_rows(const Numbers& numbers, py::ssize_t count, Eigen::Index width, const std::string& what) {
  if (numbers.ndim() != 2 || numbers.shape(0) != count || numbers.shape(1) != width)
    refuse(what, fmt::format("does not have the shape ({}, {})", count, width));
  return {numbers.data(), width};
}

py::ssize_t count_of(const Numbers& q) {
  if (q.ndim() != 2) refuse("q", fmt::format("has {} dimensions; expected 2, one row per state", q.ndim()));
  return q.shape(0);
}

// The states of a call.
struct States {
  const System& system;
  double t;
  py::ssize_t count;
  GivenRows q, v;

  State at(py::ssize_t n) const { return {t, q.row(n), v.row(n)}; }
  Result<State> checked(py::ssize_t n) const {
    State state = at(n);
    if (auto fine = check_state(system, state); !fine) {
      fine.error().where = fmt::format("state {}, {}", n, fine.error().where);
      return tl::unexpected(fine.error());
    }
    return state;
  }
  // A batch of the states from `first` on; the last one fills the lanes left over.
  Result<void> set(py::ssize_t first, BatchState& batch) const {
    batch.t = t;
    for (int lane = 0; lane < lanes; ++lane) {
      const auto state = checked(std::min(first + lane, count - 1));
      if (!state) return tl::unexpected(state.error());
      batch.set(lane, *state);
    }
    return {};
  }
};

void set(const GivenRows& rows, py::ssize_t first, py::ssize_t count, Eigen::VectorX<Lanes>& to) {
  for (int lane = 0; lane < lanes; ++lane) {
    const double* const row = rows.data + std::min(first + lane, count - 1) * rows.width;
    for (Eigen::Index i = 0; i < rows.width; ++i) to[i].set(lane, row[i]);
  }
}

// Calls work(first, last) on ranges of batches of eight states and returns the first error.
template <class Work>
Result<void> on_threads(py::ssize_t count, int threads, const Work& work) {
  std::mutex mutex;
  Result<void> answer;
  in_slabs((count + lanes - 1) / lanes, threads, [&](std::int64_t first, std::int64_t last) {
    const Result<void> mine = work(first * lanes, std::min(last * lanes, std::int64_t(count)));
    const std::lock_guard lock(mutex);
    if (!mine && answer) answer = mine;
  });
  return answer;
}

Result<void> accelerate_lanes(const States& states, const GivenRows& efforts, py::ssize_t first,
                              py::ssize_t last, double* out) {
  const System& system = states.system;
  BatchState batch(system);
  BatchWorkspace w(system);
  Eigen::VectorX<Lanes> applied(system.nv);
  for (py::ssize_t n = first; n < last; n += lanes) {
    if (auto fine = states.set(n, batch); !fine) return fine;
    if (efforts.data) set(efforts, n, states.count, applied);
    if (!accelerate(system, system.parameters, batch, w, efforts.data ? applied.data() : nullptr,
                    Wanted::accelerations))
      for (const Fault& fault : w.faults)
        if (fault) return tl::unexpected(describe(system, fault, states.t));
    for (int lane = 0; lane < std::min<py::ssize_t>(lanes, last - n); ++lane)
      for (int i = 0; i < system.nv; ++i) out[(n + lane) * system.nv + i] = w.a[i][lane];
  }
  return {};
}

Result<void> accelerate_one_by_one(const States& states, const GivenRows& efforts, py::ssize_t first,
                                   py::ssize_t last, double* out) {
  const System& system = states.system;
  Workspace w(system);
  for (py::ssize_t n = first; n < last; ++n) {
    const auto state = states.checked(n);
    if (!state) return tl::unexpected(state.error());
    const auto found = evaluate(system, *state, efforts.data ? efforts.row(n) : Eigen::VectorXd(), w);
    if (!found) return tl::unexpected(found.error());
    std::copy(found->acceleration.begin(), found->acceleration.end(), out + n * system.nv);
  }
  return {};
}

py::array accelerations_at(const CompiledScene& s, const Numbers& q, const Numbers& v, double t,
                           const py::object& efforts, int threads) {
  const System& system = s.system;
  const py::ssize_t count = count_of(q);
  const States states{system, t, count, given_rows(q, count, system.nq, "q"),
                      given_rows(v, count, system.nv, "v")};
  const Numbers applied = efforts.is_none() ? Numbers() : numbers_of(efforts, "efforts");
  const GivenRows rows = efforts.is_none() ? GivenRows() : given_rows(applied, count, system.nv, "efforts");
  py::array_t<double> out({count, py::ssize_t(system.nv)});
  double* const to = out.mutable_data();
  const bool together = bool(check_batch(system));
  released([&] {
    return on_threads(count, threads, [&](py::ssize_t first, py::ssize_t last) {
      return together ? accelerate_lanes(states, rows, first, last, to)
                      : accelerate_one_by_one(states, rows, first, last, to);
    });
  });
  return out;
}

py::array efforts_at(const CompiledScene& s, const Numbers& q, const Numbers& v, const Numbers& a, double t,
                     int threads) {
  const System& system = s.system;
  value_or_throw(check_batch(system));
  const py::ssize_t count = count_of(q);
  const States states{system, t, count, given_rows(q, count, system.nq, "q"),
                      given_rows(v, count, system.nv, "v")};
  const GivenRows given = given_rows(a, count, system.nv, "a");
  if (!std::all_of(a.data(), a.data() + a.size(), [](double x) { return std::isfinite(x); }))
    refuse("a", "contains a number that is not finite");
  py::array_t<double> out({count, py::ssize_t(system.nv)});
  double* const to = out.mutable_data();
  released([&] {
    return on_threads(count, threads, [&](py::ssize_t first, py::ssize_t last) -> Result<void> {
      BatchState batch(system);
      BatchWorkspace w(system);
      Eigen::VectorX<Lanes> wanted(system.nv), needed(system.nv);
      for (py::ssize_t n = first; n < last; n += lanes) {
        if (auto fine = states.set(n, batch); !fine) return fine;
        set(given, n, count, wanted);
        inverse_dynamics(system, system.parameters, batch, wanted, w, needed);
        for (int lane = 0; lane < std::min<py::ssize_t>(lanes, last - n); ++lane)
          for (int i = 0; i < system.nv; ++i) to[(n + lane) * system.nv + i] = needed[i][lane];
      }
      return {};
    });
  });
  return out;
}

}  // namespace

void add_batches(py::module_& m) {
  m.def(
      "accelerations", &accelerations_at, py::arg("system"), py::arg("q"), py::arg("v"), py::kw_only(),
      py::arg("t") = 0.0, py::arg("efforts") = py::none(), py::arg("threads") = 0,
      "Accelerations at N states: q (N, n_q), v (N, n_v), efforts (N, n_v) or None -> (N, n_v). All at time "
      "t, s.\n\n"
      "Scenes without constraints go eight states side by side: results equal System.accelerations but for\n"
      "rounding. threads: 0: all cores. The GIL is released.");
  m.def("inverse_dynamics", &efforts_at, py::arg("system"), py::arg("q"), py::arg("v"), py::arg("a"),
        py::kw_only(), py::arg("t") = 0.0, py::arg("threads") = 0,
        "The forces A a + B - Q that accelerations a (N, n_v) need at N states -> (N, n_v), N or N m, for "
        "scenes\n"
        "without constraints. As accelerations().");
}

}  // namespace borelli::python
