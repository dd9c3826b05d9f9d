#include "dynamics/run/function_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/equations/passes.hpp"
#include "dynamics/scene/constraint.hpp"

namespace borelli {

namespace {

// Number of intervals into which a function without knots is sampled between the ends of a step.
constexpr int sample_count = 16;

// A step over more periods than this of a periodic function is rejected unseen.
constexpr double most_periods = 16;

/// The knots of a cubic spline.
struct TableKnots {
  const std::vector<double>& at;
  bool periodic;

  /// The knots between a < b, and the shortest knot interval that [a, b] overlaps.
  std::pair<std::vector<double>, double> between(double a, double b) const {
    std::vector<double> out;
    double shortest = std::numeric_limits<double>::infinity();
    const double period = at.back() - at.front();
    const double first = periodic ? std::floor((a - at.front()) / period) : 0,
                 last = periodic ? std::floor((b - at.front()) / period) : 0;
    for (double k = first; k <= last; ++k)
      for (std::size_t i = periodic ? 1 : 0; i < at.size(); ++i) {
        const double x = at[i] + k * period;
        if (x > a && x < b) out.push_back(x);
        if (i > 0 && x > a && at[i - 1] + k * period < b) shortest = std::min(shortest, at[i] - at[i - 1]);
      }
    return {out, shortest};
  }
};

/// The largest deviation of f at `places` from the quintic through values, slopes and curvatures at both ends
/// of [a, b].
template <class F>
double largest_departure(const F& f, double a, double b, const std::vector<double>& places) {
  const double h = b - a;
  const auto fa = f(a), fb = f(b);
  const double c0 = fa[0], c1 = fa[1] * h, c2 = fa[2] * h * h / 2;
  const double p = fb[0] - c0 - c1 - c2, q = fb[1] * h - c1 - 2 * c2, r = fb[2] * h * h / 2 - c2;
  const double c3 = 10 * p - 4 * q + r, c4 = -15 * p + 7 * q - 2 * r, c5 = 6 * p - 3 * q + r;
  double largest = 0;
  for (const double x : places) {
    const double s = (x - a) / h;
    const double value = c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
    largest = std::max(largest, std::abs(value - f(x)[0]));
  }
  return largest;
}

/// Whether the ends determine the spline between them to within `allowed`.
template <class F>
bool ends_determine(const F& f, const TableKnots& knots, double a, double b, double allowed) {
  if (a > b) std::swap(a, b);
  if (knots.periodic && b - a > most_periods * (knots.at.back() - knots.at.front())) return false;
  auto [places, shortest] = knots.between(a, b);
  if (places.empty() || b - a <= shortest / 2) return true;
  double before = a;
  for (std::size_t i = 0, count = places.size(); i <= count; ++i) {  // and the midpoints between them
    const double next = i < count ? places[i] : b;
    places.push_back((before + next) / 2);
    before = next;
  }
  return largest_departure(f, a, b, places) <= allowed;
}

template <class F>
bool ends_determine(const F& f, double a, double b, double allowed) {
  std::vector<double> places;
  for (int i = 1; i < sample_count; ++i) places.push_back(a + (b - a) * i / sample_count);
  return largest_departure(f, a, b, places) <= allowed;
}

bool followed(const CoordinateFunction& kind, const SiteReader<double>& a, const SiteReader<double>& b,
              double allowed) {
  enum { on_coordinate, of_coordinate };
  const double from = a.position(of_coordinate), to = b.position(of_coordinate);
  if (from == to) return true;
  const auto f = [&](double x) {
    const TimeValue value = at(kind.function, x);
    return std::array{value.value, value.rate, value.acceleration};
  };
  if (const auto* table = std::get_if<Table>(&kind.function))
    return ends_determine(f, TableKnots{table->times, table->ends == SplineEnds::periodic}, from, to,
                          allowed);
  if (const auto* sine = std::get_if<Sine>(&kind.function); sine && std::abs(sine->amplitude) > allowed) {
    const double turn = std::abs(sine->angular_frequency * (to - from));
    if (turn > 2 * M_PI) return false;  // samples might hit the same phase of each period
    return turn < M_PI / 8 || ends_determine(f, from, to, allowed);
  }
  return ends_determine(f, from, to, allowed);
}

bool followed(const PointOnCurve& kind, const SiteReader<double>& a, const SiteReader<double>& b,
              double allowed) {
  enum { point_site, curve_site };
  const auto place = [&](const SiteReader<double>& reader) {
    const Pose X = reader.frame(curve_site);
    return kind.length_at(X.R.transpose() * (reader.point(point_site, kind.point.point).p - X.p));
  };
  const std::vector<double>& knots = kind.path[0].knots();
  double from = place(a), to = place(b);
  if (const double round = knots.back() - knots.front(); kind.closed)  // the shorter way round
    to -= round * std::round((to - from) / round);
  if (from == to) return true;
  for (const CubicSpline& path : kind.path) {
    const auto f = [&](double s) {
      const SplineValue<double> value = path(s);
      return std::array{value.value, value.slope, value.curvature};
    };
    if (!ends_determine(f, TableKnots{knots, kind.closed}, from, to, allowed)) return false;
  }
  return true;
}

template <class Kind>
bool followed(const Kind&, const SiteReader<double>&, const SiteReader<double>&, double) {
  return true;
}

}  // namespace

FunctionWatch::FunctionWatch(const System& system, const Parameters& parameters, double allowed)
    : system_(system), parameters_(parameters), allowed_(allowed) {
  for (std::size_t i = 0; i < parameters.constraints.size(); ++i)
    if (const auto& kind = parameters.constraints[i].kind;
        std::holds_alternative<CoordinateFunction>(kind) || std::holds_alternative<PointOnCurve>(kind))
      watched_.push_back(i);
}

std::string FunctionWatch::passed_over(const Kinematics& a, const Kinematics& b) const {
  SiteReader<double> at_a(system_, parameters_, a), at_b(system_, parameters_, b);
  for (const std::size_t i : watched_) {
    const Action& action = system_.constraints[i];
    at_a.turn_to(action);
    at_b.turn_to(action);
    const double allowed = allowed_ * system_.row_scale[action.first_row];
    if (!std::visit([&](const auto& kind) { return followed(kind, at_a, at_b, allowed); },
                    parameters_.constraints[i].kind))
      return parameters_.constraints[i].name;
  }
  return "";
}

}  // namespace borelli
