// Inverse kinematics of a human: error against time per frame. Markers with 5 mm of noise follow a smooth
// motion of the human; each row stops the fit at another tolerance. The error is the largest difference of a
// coordinate from the fit at 1e-12, over all frames.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/kinematics.hpp"
#include "dynamics/formats/model_file.hpp"
#include "dynamics/inverse/marker_fit.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3Xd;
using Eigen::VectorXd;

constexpr int frames = 250, wanted_markers = 40;
constexpr double step = 0.01;  // s

struct Seen {
  std::vector<FollowedMarker> markers;
  std::vector<Matrix3Xd> frames;
  VectorXd start;
};

/// Markers spread evenly over all solids, at random points up to 0.1 m from the solid's origin.
Seen watch(const System& system) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.1, 0.1), angle(-0.5, 0.5), phase(0, 2 * std::numbers::pi);
  std::normal_distribution<double> noise(0, 0.005);
  Seen out;
  for (int m = 0; m < wanted_markers; ++m) {
    const std::string& solid = system.solids[std::size_t(m) % system.solids.size()];
    out.markers.push_back({fmt::format("m{}", m), {solid, {place(random), place(random), place(random)}}, 1});
  }
  VectorXd size(system.nv), shift(system.nv);
  for (int u = 0; u < system.nv; ++u) {
    size[u] = angle(random);
    shift[u] = phase(random);
  }
  out.start = system.initial.q;
  Kinematics kinematics(system, Equations::recursive);
  for (int f = 0; f < frames; ++f) {
    VectorXd x(system.nv), q = system.initial.q;
    for (int u = 0; u < system.nv; ++u) x[u] = size[u] * std::sin(2 * std::numbers::pi * f * step + shift[u]);
    from_local_coordinates(system, system.initial.q.data(), x.data(), q.data());
    if (f == 0) out.start = q;
    update_kinematics(system, system.parameters, 0, q.data(), nullptr, kinematics);
    Matrix3Xd seen(3, wanted_markers);
    for (int m = 0; m < wanted_markers; ++m) {
      const FollowedMarker& marker = out.markers[std::size_t(m)];
      const auto solid = std::size_t(std::find(system.solids.begin(), system.solids.end(), marker.at.solid) -
                                     system.solids.begin());
      seen.col(m) = kinematics.bodies[std::size_t(system.solid_bodies[solid])].X *
                    (system.parameters.solid_places[solid] * marker.at.point);
      for (int k = 0; k < 3; ++k) seen(k, m) += noise(random);
    }
    out.frames.push_back(seen);
  }
  return out;
}

struct Fitted {
  std::vector<VectorXd> q;
  double milliseconds = 0;  ///< per frame, median of the frames
  double iterations = 0;
};

Fitted fit(const System& system, const Seen& seen, double tolerance) {
  auto made = MarkerFit::create(system, seen.markers, {},
                                {.tolerance = tolerance, .most_iterations = 200, .within_ranges = false});
  if (!made) throw std::runtime_error(made.error().message());
  Fitted out;
  VectorXd q = seen.start;
  std::vector<double> times;
  for (const Matrix3Xd& frame : seen.frames) {
    const auto began = std::chrono::steady_clock::now();
    const auto found = made->fit(0, frame, VectorXd(), q);
    times.push_back(1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    if (!found || !found->converged) throw std::runtime_error("a frame did not converge");
    out.iterations += double(found->iterations) / frames;
    out.q.push_back(q);
  }
  std::nth_element(times.begin(), times.begin() + frames / 2, times.end());
  out.milliseconds = times[frames / 2];
  return out;
}

int run() {
  const auto model = read_model(test::shared_folder() + "/models/bench/human.xml");
  if (!model) {
    fmt::print(stderr, "{}\n", model.error().message());
    return 1;
  }
  const auto system = compile(model->scene);
  if (!system) {
    fmt::print(stderr, "{}\n", system.error().message());
    return 1;
  }
  const Seen seen = watch(*system);
  const Fitted exact = fit(*system, seen, 1e-12);
  fmt::print("{} coordinates, {} markers, {} frames\n\n", system->nv, wanted_markers, frames);
  fmt::print("| tolerance | error, rad or m | iterations | ms a frame |\n| --- | --- | --- | --- |\n");
  for (double tolerance : {1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10}) {
    const Fitted one = fit(*system, seen, tolerance);
    double error = 0;
    for (int f = 0; f < frames; ++f)
      error = std::max(error, (one.q[std::size_t(f)] - exact.q[std::size_t(f)]).cwiseAbs().maxCoeff());
    fmt::print("| {:.0e} | {:.1e} | {:.1f} | {:.4f} |\n", tolerance, error, one.iterations, one.milliseconds);
  }
  return 0;
}

}  // namespace
}  // namespace borelli

int main() { return borelli::run(); }
