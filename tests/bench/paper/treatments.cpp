#include "treatments.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/methods/integrator.hpp"

namespace borelli {
namespace {

using Eigen::VectorXd;

// m, rad: step of central differences; their error is about eps^(2/3) for quantities of size 1
constexpr double step = 6e-6;

class Direct : public Treatment {
 public:
  explicit Direct(const System& system)
      : system_(system), kinematics_(system, Equations::recursive), lean_(VectorXd::Zero(system.nv)) {}

  void terms(const VectorXd& q, const VectorXd& v, TreatedTerms& out) override {
    const int n = system_.nv;
    // (the potential energy drops out of the first two)
    VectorXd own(n), u = VectorXd::Zero(n);
    const double rest = lagrangian(q, u);
    for (int i = 0; i < n; ++i) {
      u[i] = 1;
      own[i] = lagrangian(q, u) - rest;
      out.A(i, i) = 2 * own[i];
      for (int j = 0; j < i; ++j) {
        u[j] = 1;
        out.A(i, j) = out.A(j, i) = lagrangian(q, u) - rest - own[i] - own[j];
        u[j] = 0;
      }
      u[i] = 0;
    }
    const double along = step / std::max(1.0, v.norm());
    const VectorXd before = q - along * v, after = q + along * v;
    for (int i = 0; i < n; ++i) {
      const double momentum_rate = (momentum(after, v, i) - momentum(before, v, i)) / (2 * along);
      lean_[i] = step;
      out.f[i] = (lagrangian(q + lean_, v) - lagrangian(q - lean_, v)) / (2 * step) - momentum_rate;
      lean_[i] = 0;
    }
    for (int row = 0; row < system_.rows; ++row) {
      out.h[row] = height(q, v, row).first;
      for (int j = 0; j < n; ++j) {
        u[j] = 1;
        out.L(row, j) = height(q, u, row).second;
        u[j] = 0;
      }
      out.E[row] = (height(after, v, row).second - height(before, v, row).second) / (2 * along);
    }
  }

 private:
  void update(const VectorXd& q, const VectorXd& v) {
    update_kinematics(system_, system_.parameters, 0, q.data(), v.data(), kinematics_);
  }

  /// K - V, J.
  double lagrangian(const VectorXd& q, const VectorXd& v) {
    update(q, v);
    double out = 0;
    for (std::size_t k = 1; k < system_.bodies.size(); ++k) {
      const BodyMotion& body = kinematics_.bodies[k];
      const Inertial& inertial = system_.parameters.inertials[k];
      const Eigen::Vector3d w = body.X.R.transpose() * body.w;
      out += 0.5 * inertial.mass * body.v.squaredNorm() + 0.5 * w.dot(inertial.tensor * w) +
             inertial.mass * system_.parameters.gravity.dot(body.g);
    }
    return out;
  }

  /// dK/dv_i, exact.
  double momentum(const VectorXd& q, const VectorXd& v, int i) {
    lean_[i] = 1;
    const double out = 0.5 * (lagrangian(q, v + lean_) - lagrangian(q, v - lean_));
    lean_[i] = 0;
    return out;
  }

  /// Height of the row's point above its plane, m, and its rate, m/s.
  std::pair<double, double> height(const VectorXd& q, const VectorXd& v, int row) {
    const auto& held = std::get<PointOnPlane>(system_.parameters.constraints[row].kind);
    const Site& site = system_.sites[system_.constraints[row].first_site];
    update(q, v);
    const BodyMotion& body = kinematics_.bodies[site.body];
    const Eigen::Vector3d arm =
        body.X.R * (system_.parameters.solid_places[site.solid] * held.point.point) + body.X.p - body.g;
    const Eigen::Vector3d normal = held.plane.normal.normalized();
    return {normal.dot(body.g + arm - held.plane.on.point), normal.dot(body.v + body.w.cross(arm))};
  }

  const System& system_;
  Kinematics kinematics_;
  VectorXd lean_;
};

class Symbolic : public Treatment {
 public:
  explicit Symbolic(SymbolicTerms function) : function_(function) {}
  void terms(const VectorXd& q, const VectorXd& v, TreatedTerms& out) override {
    function_(q.data(), v.data(), out.A.data(), out.f.data(), out.L.data(), out.E.data(), out.h.data());
  }

 private:
  SymbolicTerms function_;
};

class TreatedFlow : public Flow {
 public:
  TreatedFlow(const System& system, Treatment& treatment) : system_(system), treatment_(treatment) {
    const int n = system.nv, rows = system.rows;
    terms_.A.setZero(n, n), terms_.L.setZero(rows, n);
    terms_.f.setZero(n), terms_.E.setZero(rows), terms_.h.setZero(rows);
    scale_.resize(2 * n);
    q_.resize(n), v_.resize(n);
  }

  Eigen::Index size() const override { return 2 * system_.nv; }
  const VectorXd& error_scale() const override { return scale_; }
  Eigen::Index positions() const override { return system_.nv; }
  void position_rate(const VectorXd& y, VectorXd& dy) override { dy.head(system_.nv) = y.tail(system_.nv); }

  bool derivative(double /*t*/, const VectorXd& y, VectorXd& dy) override {
    const int n = system_.nv;
    ++evaluations;
    q_ = y.head(n), v_ = y.tail(n);
    treatment_.terms(q_, v_, terms_);
    factor_.compute(terms_.A);
    if (factor_.info() != Eigen::Success) return false;
    dy.resize(2 * n);
    dy.head(n) = v_;
    if (system_.rows == 0) {
      dy.tail(n) = factor_.solve(terms_.f);
      return true;
    }
    const SimulationSettings& s = system_.settings;
    const VectorXd free = factor_.solve(terms_.f);
    const Eigen::MatrixXd spread = factor_.solve(terms_.L.transpose());
    const VectorXd missing = -(terms_.L * free + terms_.E + 2 * s.baumgarte_alpha * (terms_.L * v_) +
                               s.baumgarte_beta * s.baumgarte_beta * terms_.h);
    const Eigen::LLT<Eigen::MatrixXd> rows(terms_.L * spread);
    if (rows.info() != Eigen::Success) return false;
    dy.tail(n) = free + spread * rows.solve(missing);
    return true;
  }

  /// The scale of errors, as in our own runs (dynamics/README.md).
  void set_scale(const VectorXd& y) {
    const int n = system_.nv;
    for (const CoordinateInfo& info : system_.coordinates) {
      const int i = info.v_index;
      const double unit = system_.velocity_scale[i];
      scale_[i] = info.angle ? unit : std::max(unit, std::abs(y[i]));
      scale_[n + i] = unit + std::abs(y[n + i]);
    }
  }

  long evaluations = 0;

 private:
  const System& system_;
  Treatment& treatment_;
  TreatedTerms terms_;
  VectorXd scale_, q_, v_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

/// Steps from y at t exactly to `end`. Returns false if it fails.
class Stepper {
 public:
  Stepper(TreatedFlow& flow, Integrator& integrator, double first, bool fixed)
      : flow_(flow), integrator_(integrator), step_(first), fixed_(fixed) {}

  bool advance(double& t, double end, VectorXd& y, const std::function<bool()>& go_on) {
    const double length = end - t;
    const long steps = fixed_ ? std::max(1L, std::lround(length / step_)) : 0;
    const double start = t;
    for (long made = 0; t < end;) {
      const bool last = fixed_ ? made + 1 == steps : t + step_ * (1 + 1e-9) >= end;
      const double h = fixed_ ? length / double(steps) : last ? end - t : step_;
      if (!known_ && !flow_.derivative(t, y, dy_)) return false;
      known_ = true;
      flow_.set_scale(y);
      out_.resize(y.size());
      const Attempt attempt = integrator_.attempt(flow_, t, h, y, dy_, out_);
      if (!attempt.evaluated && fixed_) return false;
      if (!attempt.evaluated || !attempt.accepted) {
        step_ = attempt.evaluated ? attempt.next_step : 0.1 * h;
        if (!(step_ > 1e-14 * end) || !go_on()) return false;
        continue;
      }
      const double reached = attempt.made > 0 ? attempt.made : h;
      ++made;
      t = fixed_ ? start + length * double(made) / double(steps) : last && reached == h ? end : t + reached;
      // a step shortened by the end says little about the next step
      if (!fixed_) step_ = last ? std::max(step_, attempt.next_step) : attempt.next_step;
      y.swap(out_);
      known_ = false;
      if (!y.allFinite() || (made % 64 == 0 && !go_on())) return false;
      if (fixed_ && made == steps) t = end;
    }
    return true;
  }

 private:
  TreatedFlow& flow_;
  Integrator& integrator_;
  double step_;
  bool fixed_, known_ = false;
  VectorXd dy_ = VectorXd::Zero(flow_.size()), out_;
};

Result<OtherRun> run(const System& system, const std::string& method, double setting,
                     const std::vector<double>& times, Treatment& treatment,
                     const std::function<bool()>& go_on) {
  const bool fixed = !method_is_adaptive(method);
  auto integrator = make_integrator(method, setting);
  if (!integrator) return tl::unexpected(integrator.error());
  TreatedFlow flow(system, treatment);
  Stepper stepper(flow, **integrator, fixed ? setting : system.settings.step, fixed);
  const int n = system.nv;
  double t = system.initial.t;
  VectorXd y(2 * n);
  y << system.initial.q, system.initial.v;
  Kinematics kinematics(system, Equations::recursive);
  OtherRun out;
  out.energy = out.constraint = std::nan("");
  for (const double end : times) {
    if (!stepper.advance(t, end, y, go_on))
      return failure("", "the run did not come to its end in the time allowed, or the equations have none");
    const VectorXd q = y.head(n), v = y.tail(n);
    update_kinematics(system, system.parameters, 0, q.data(), v.data(), kinematics);
    for (std::size_t i = 0; i < system.solids.size(); ++i)
      out.poses.push_back(kinematics.bodies[system.solid_bodies[i]].X * system.parameters.solid_places[i]);
  }
  out.evaluations = flow.evaluations;
  return out;
}

}  // namespace

Result<std::unique_ptr<Treatment>> direct_treatment(const System& system) {
  if (system.driven_nv > 0 || system.nq != system.nv || !system.efforts.empty())
    return failure(system.scene, "has drives, balls or efforts: the direct treatment is for none of them");
  for (const Constraint& c : system.parameters.constraints)
    if (!std::holds_alternative<PointOnPlane>(c.kind) ||
        std::get<PointOnPlane>(c.kind).plane.on.solid != world_name)
      return failure(system.scene, "has constraints that are no points in planes of the world");
  return std::make_unique<Direct>(system);
}

std::unique_ptr<Treatment> symbolic_treatment(SymbolicTerms terms) {
  return std::make_unique<Symbolic>(terms);
}

Eigen::VectorXd accelerations(const System& system, Treatment& treatment, const VectorXd& q,
                              const VectorXd& v) {
  TreatedFlow flow(system, treatment);
  VectorXd y(2 * system.nv), dy = VectorXd::Constant(2 * system.nv, std::nan(""));
  y << q, v;
  flow.derivative(0, y, dy);
  return dy.tail(system.nv);
}

OtherMethod treated_method(const System& system, const std::string& name, const std::string& integrator,
                           std::function<std::unique_ptr<Treatment>()> make) {
  return {
      name + ", " + integrator, method_is_adaptive(integrator),
      [&system, integrator, make = std::move(make)](double setting, const std::vector<double>& times,
                                                    const std::function<bool()>& go_on) -> Result<OtherRun> {
        const auto treatment = make();
        const double start = processor_time();
        auto out = run(system, integrator, setting, times, *treatment, go_on);
        if (out) out->seconds = processor_time() - start;
        return out;
      }};
}

}  // namespace borelli
