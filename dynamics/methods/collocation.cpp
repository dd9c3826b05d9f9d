#include "dynamics/methods/collocation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/methods/slope_jacobian.hpp"
#include "dynamics/numbers/exceeds.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

namespace {

constexpr int node_count = Collocation::nodes, half = node_count / 2;

// Fraction of the tolerance that the iteration may leave as residual.
constexpr double left_undone = 0.03;
// Changes below `value_rounding` are rounding; rates are not estimated from changes below tells_rate *
// value_rounding.
constexpr double value_rounding = 1e-15, tells_rate = 1e4;
// Lower bound of the contraction rate, so that one lucky round does not end the iteration.
constexpr double least_rate = 0.01;
// Iterations with a rate above slowest_rate are abandoned. Steps aim at aimed_rate and at most aimed_rounds.
constexpr double slowest_rate = 0.9, aimed_rate = 0.3;
constexpr int most_node_rounds = 12, aimed_rounds = 8;
// The check for a hopeless step runs every so many rounds; most steps end before the first check.
constexpr int rounds_to_judgement = 4;
// For shortened steps, whose error is not judged: the most rounds, and the most bisections of the step.
constexpr int most_rounds_to_part = 60, most_divisions = 8;
// In tolerances: the error that steps aim at, and an error that further rounds cannot repair.
constexpr double aimed_error = 0.005, hopeless_error = 10;
// In tolerances: a smaller last coefficient shows no error (and may be rounding).
constexpr double too_small = 0.05;
// (1/2)^7: bound on how much slower the coefficients may fall in the end than over all degrees.
constexpr double slows = 1. / 128;
// Relative to the last coefficient: a smaller change no longer alters it.
constexpr double settled_shape = 0.1;
// Bounds of the ratio of successive steps.
constexpr double most_growth = 2, least_shrink = 0.2;
// A step longer than this multiple of the previous one starts without extrapolation.
constexpr double farthest = 2.5;
// Growth of a coefficient over the next one when slopes are extrapolated. Beyond this bound, extrapolation
// from few nodes is better than from many.
constexpr double farthest_growth = 1.2;
// The slope jumps at an end of the step if its deviation there exceeds this multiple of what the last
// coefficients explain.
constexpr double node_leap = 8;

/// One number per node, or one weight per node.
using AtNodes = Lanes;

double legendre(int degree, double x) {
  double before = 0, now = 1;
  for (int k = 0; k < degree; ++k)
    before = std::exchange(now, ((2 * k + 1) * x * now - k * before) / (k + 1));
  return now;
}

/// The Gauss nodes on [0, 1] and derived tables, in lanes of type L.
template <class L>
struct TablesOf {
  double c[node_count], b[node_count];
  L places;                    ///< c
  L coupling[node_count];      ///< per node: contribution of its slope to the moves to all nodes
  L weights;                   ///< b
  L coefficients[node_count];  ///< per node, one lane per degree: Legendre coefficients of the slopes
  L start, end;                ///< weights that extrapolate a polynomial from the nodes to 0 and 1

  TablesOf() {
    for (int i = 0; i < node_count; ++i) {
      double x = -std::cos(M_PI * (i + 0.75) / (node_count + 0.5)), slope = 1;
      for (int k = 0; k < 10; ++k) {
        slope = node_count * (legendre(node_count - 1, x) - x * legendre(node_count, x)) / (1 - x * x);
        x -= legendre(node_count, x) / slope;
      }
      c[i] = (1 + x) / 2;
      b[i] = 1 / ((1 - x * x) * slope * slope);
    }
    for (int i = 0; i < node_count; ++i) {
      places.set(i, c[i]);
      weights.set(i, b[i]);
      start.set(i, lagrange(i, 0));
      end.set(i, lagrange(i, 1));
      for (int degree = 0; degree < node_count; ++degree)
        coefficients[i].set(degree, (2 * degree + 1) * b[i] * legendre(degree, 2 * c[i] - 1));
      for (int j = 0; j < node_count; ++j) {
        double integral = 0;
        for (int k = 0; k < node_count; ++k) integral += c[i] * b[k] * lagrange(j, c[i] * c[k]);
        coupling[j].set(i, integral);
      }
    }
  }
  double lagrange(int j, double x) const {
    double value = 1;
    for (int k = 0; k < node_count; ++k)
      if (k != j) value *= (x - c[k]) / (c[j] - c[k]);
    return value;
  }
};

const TablesOf<AtNodes> tables;

template <class L>
double sum(const L& parts) {
  return ((parts[0] + parts[4]) + (parts[1] + parts[5])) + ((parts[2] + parts[6]) + (parts[3] + parts[7]));
}

/// The weighted sum of the slopes at the nodes.
template <class L>
L combined(const L* weights, const L& slopes) {
  L even = 0, odd = 0;
  for (int k = 0; k < node_count; k += 2) {
    even += weights[k] * slopes[k];
    odd += weights[k + 1] * slopes[k + 1];
  }
  return even + odd;
}

/// stages <- y plus h times the integrated slopes, for components from `from` to before `to`. Returns the
/// largest change of a stage relative to the error scale; NaN if any stage is NaN.
template <class L>
double move(const TablesOf<L>& by, double h, const double* y, const double* scale, Eigen::Index from,
            Eigen::Index to, const L* slopes, L* stages) {
  L most = 0, none = 0;
  for (Eigen::Index i = from; i < to; ++i) {
    const L moved = y[i] + h * combined(by.coupling, slopes[i]);
    const L change = abs(moved - stages[i]) * (1 / scale[i]);
    most = choose(most < change, change, most);
    none += 0 * change;
    stages[i] = moved;
  }
  // Branch-free maximum: the branches would be unpredictable.
  return std::max(std::max(std::max(most[0], most[4]), std::max(most[1], most[5])),
                  std::max(std::max(most[2], most[6]), std::max(most[3], most[7]))) +
         sum(none);
}

/// Initial stages: velocities as at the start, positions extrapolated with the start's rates, at which rates
/// are then evaluated.
template <class L>
void begin_stages(const TablesOf<L>& by, double h, const double* y, const double* dy, Eigen::Index positions,
                  Eigen::Index size, L* stages) {
  for (Eigen::Index i = 0; i < positions; ++i) stages[i] = y[i] + h * dy[i] * by.places;
  for (Eigen::Index i = positions; i < size; ++i) stages[i] = y[i];
}

/// out <- y plus the integral of the slopes over the step.
template <class L>
void finish(const TablesOf<L>& by, double h, const double* y, Eigen::Index size, const L* slopes,
            double* out) {
  for (Eigen::Index i = 0; i < size; ++i) out[i] = y[i] + h * sum(L(by.weights * slopes[i]));
}

/// Per component with a scale, one lane per degree: the Legendre coefficients of the slopes.
template <class L>
void find_coefficients(const TablesOf<L>& by, const L* slopes, const Eigen::VectorXd& scale,
                       L* coefficients) {
  for (Eigen::Index i = 0; i < scale.size(); ++i)
    if (!std::isinf(scale[i])) coefficients[i] = combined(by.coefficients, slopes[i]);
}

/// The points at which a polynomial is known: nodes `from` to before `to` of a step, and the start of the
/// next step, listed last.
struct Support {
  int from, to;
  double at[node_count + 1], scale[node_count + 1];

  Support(int from_node, int to_node, double start) : from(from_node), to(to_node) {
    std::copy(tables.c, tables.c + node_count, at);
    at[node_count] = start;
    for (int k = 0; k <= node_count; ++k) {
      scale[k] = 1;
      for (int j = 0; j <= node_count; ++j)
        if (j != k && holds(j)) scale[k] /= at[k] - at[j];
    }
  }
  bool holds(int place) const { return place == node_count || (place >= from && place < to); }
};

/// The values of that polynomial at eight other points, as weights of the known values.
template <class L>
struct Continuation {
  L weights[node_count + 1];

  Continuation(const Support& by, const L& where) {
    L before = where - by.at[node_count], after = 1;
    for (L& weight : weights) weight = 0;
    for (int k = by.from; k < by.to; ++k) {
      weights[k] = before * by.scale[k];
      before *= where - by.at[k];
    }
    for (int k = by.to; k-- > by.from;) {
      weights[k] *= after;
      after *= where - by.at[k];
    }
    weights[node_count] = after * by.scale[node_count];
  }
};

const Support of_this_step(0, node_count, 0), of_step_before(1, node_count, 1),
    of_its_end(node_count - 2, node_count, 1), of_first_half(0, half, 0);

/// slopes <- the polynomial through the known values at the points `where`, for components from `from` to
/// before `to`.
template <class L>
void continue_slopes(const Support& by, const L& where, Eigen::Index from, Eigen::Index to,
                     const double* start, L* slopes) {
  const Continuation<L> continuation(by, where);
  for (Eigen::Index i = from; i < to; ++i) {
    const L known = combined(continuation.weights, slopes[i]);
    slopes[i] = known + continuation.weights[node_count] * start[i];
  }
}

void continue_slopes(const Support& by, const Lanes& where, const Flow& flow, const Eigen::VectorXd& dy,
                     Eigen::VectorX<Lanes>& slopes) {
  in_registers([]<int>(auto&... each) { continue_slopes(each...); }, by, where, flow.positions(),
               acting_components(flow), dy.data(), slopes.data());
}

/// Growth of Legendre polynomials per degree at x; 1 within [-1, 1].
double growth(double x) { return x + std::sqrt(x * x - 1); }

}  // namespace

void Collocation::reset() {
  last_ = {};
  rejected_ = false;
}

bool Collocation::keep(Keeper& k) {
  Eigen::MatrixXd slopes(node_count, slopes_.size());
  for (Eigen::Index i = 0; i < slopes_.size(); ++i) slopes_[i].store(slopes.col(i).data());
  k(last_.known, last_.step, last_.rate, last_.fall, rejected_, slopes);
  slopes_.resize(slopes.cols());
  for (Eigen::Index i = 0; i < slopes.cols(); ++i) slopes_[i] = Lanes::load(slopes.col(i).data());
  return true;
}

/// Initial slopes: extrapolated from the last nodes of the previous step and the slope at the start. The fall
/// of the coefficients decides how many nodes to use.
void Collocation::guess(const Flow& flow, double h, const Eigen::VectorXd& dy) {
  const double ratio = h / last_.step;
  if (last_.known == Known::nothing || ratio > farthest) {
    slopes_.resize(dy.size());
    for (Eigen::Index i = 0; i < dy.size(); ++i) slopes_[i] = dy[i];
    last_.rate = 1;
    return;
  }
  const bool before = last_.known == Known::step_before;
  // Only the first half of the nodes counts here. Without lanes, these nodes predict the others again; with
  // lanes, extrapolating from more nodes up to the last one costs more rounds, not fewer.
  const bool far = last_.fall * growth(1 + 2 * tables.c[half - 1] * ratio) > farthest_growth;
  const Support& by = !before ? of_this_step : far ? of_its_end : of_step_before;
  continue_slopes(by, by.at[node_count] + ratio * tables.places, flow, dy, slopes_);
  last_.rate = std::min(1., last_.rate * ratio * ratio);
}

/// stages_ <- the stages by the present slopes; positions use the rates at the stages of the velocities.
/// Returns the largest change.
double Collocation::place(Flow& flow, double h, const Eigen::VectorXd& y) {
  const Eigen::Index positions = flow.positions(), acting = acting_components(flow);
  const double* scale = flow.error_scale().data();
  const auto move_these = [&](Eigen::Index from, Eigen::Index to) {
    return in_registers([]<int>(auto&... each) { return move(each...); }, tables, h, y.data(), scale, from,
                        to, std::as_const(slopes_).data(), stages_.data());
  };
  double change = move_these(positions, acting);
  if (positions > 0) {
    flow.position_rates(stages_, slopes_);
    if (const double moved = move_these(0, positions); exceeds(moved, change)) change = moved;
  }
  return change;
}

/// slopes_ <- the slopes at the stages of nodes `from` to before `to`.
bool Collocation::evaluate(Flow& flow, double t, double h, int from, int to) {
  const Eigen::Index size = stages_.size();
  stage_.resize(size);
  for (int node = from; node < to; ++node) {
    for (Eigen::Index i = 0; i < size; ++i) stage_[i] = stages_[i][node];
    if (!flow.derivative(t + tables.c[node] * h, stage_, slope_)) return false;
    for (Eigen::Index i = 0; i < size; ++i) slopes_[i].set(node, slope_[i]);
  }
  return true;
}

/// slopes_ <- the slopes at all stages. With `predict`, the first half of the nodes predicts the stages of
/// the second half (only without lanes).
bool Collocation::evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                           const Eigen::VectorXd& dy, bool predict) {
  if (flow.has_lanes()) return flow.derivatives(stages_, node_count, slopes_);
  if (!evaluate(flow, t, h, 0, half)) return false;
  if (predict) {
    continue_slopes(of_first_half, tables.places, flow, dy, slopes_);
    place(flow, h, y);
  }
  return evaluate(flow, t, h, half, node_count);
}

Collocation::Outcome Collocation::solve(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                        const Eigen::VectorXd& dy, bool judged, Eigen::VectorXd& out) {
  const bool predict = last_.known != Known::this_step;
  guess(flow, h, dy);
  last_.known = Known::nothing;
  last_.step = h;
  const Eigen::Index size = y.size(), positions = flow.positions();
  stages_.resize(size);
  in_registers([]<int>(auto&... each) { begin_stages(each...); }, tables, h, y.data(), dy.data(), positions,
               size, stages_.data());
  place(flow, h, y);
  double before = std::numeric_limits<double>::infinity();
  for (rounds_ = 1;; ++rounds_) {
    if (!evaluate(flow, t, h, y, dy, predict && rounds_ == 1)) return Outcome::not_evaluated;
    const double change = place(flow, h, y);
    if (!std::isfinite(change)) return Outcome::unsettled;
    if (change <= value_rounding || (rounds_ > 1 && before <= tells_rate * value_rounding))
      last_.rate = least_rate;
    else if (rounds_ > 1)
      last_.rate = std::max(change / before, least_rate);
    if (last_.rate < 1 && last_.rate * change <= left_undone * tolerance_ * (1 - last_.rate)) {
      // The slopes after one round are rough; a longer next step may need more rounds.
      if (rounds_ > 1 || !judged || change <= value_rounding || judge(flow, h).error <= aimed_error) break;
    } else if (judged) {
      if (rounds_ % rounds_to_judgement == 0) {
        const Judgement now = judge(flow, h);
        if (now.error > hopeless_error && change < settled_shape * now.coefficient) return Outcome::hopeless;
      }
      if (rounds_ > 2 && (last_.rate > slowest_rate || rounds_ >= most_node_rounds))
        return Outcome::unsettled;
    } else if (rounds_ == most_rounds_to_part) {
      return Outcome::unsettled;
    }
    before = change;
  }
  out.resize(size);
  in_registers([]<int>(auto&... each) { finish(each...); }, tables, h, y.data(), size,
               std::as_const(slopes_).data(), out.data());
  return Outcome::solved;
}

/// The error of the step. Legendre coefficients of the slopes fall by a roughly constant ratio per component.
/// The quadrature error begins with the sixteenth coefficient.
Collocation::Judgement Collocation::judge(const Flow& flow, double h) {
  const Eigen::VectorXd& scale = flow.error_scale();
  coefficients_.resize(scale.size());
  in_registers([]<int>(auto&... each) { find_coefficients(each...); }, tables, std::as_const(slopes_).data(),
               scale, coefficients_.data());
  Judgement out;
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    if (std::isinf(scale[i])) continue;
    const double per = h / scale[i];
    const auto size = [&](int degree) { return std::abs(coefficients_[i][degree]) * per; };
    const double last = size(node_count - 1), last_but_one = size(node_count - 2);
    if (std::max(last, last_but_one) <= too_small * tolerance_) continue;
    const double falls = std::max(last, last_but_one) / std::max(size(node_count - 5), size(node_count - 6));
    const double fall = falls < 1 ? std::sqrt(std::sqrt(falls)) : 1;
    const double coefficient = std::max(last, fall * last_but_one);
    if (coefficient <= too_small * tolerance_) continue;
    // Coefficients that fall much slower at high degrees may come from a kink and then fall even slower.
    const double fourth = fall * fall * fall * fall, seventh = fourth * fall * fall * fall;
    const bool flattens = slows * seventh * size(0) > coefficient;
    const double error = coefficient * fourth * (flattens ? 1 : fourth * fall) / tolerance_;
    if (out.worst < 0 || exceeds(error, out.error)) out = {error, fall, coefficient, int(i)};
  }
  return out;
}

/// Whether the slope jumps between an end of the step and the nearest node by enough to cause an error above
/// the tolerance. slope_ is the slope at the step's end.
bool Collocation::leaps_at_an_end(const Flow& flow, double h, const Eigen::VectorXd& dy) const {
  const Eigen::VectorXd& scale = flow.error_scale();
  for (Eigen::Index i = flow.positions(); i < scale.size(); ++i) {
    if (std::isinf(scale[i])) continue;  // not controlled
    const auto at = [&](const AtNodes& weights) { return sum(AtNodes(weights * slopes_[i])); };
    const double off = std::max(std::abs(at(tables.start) - dy[i]), std::abs(at(tables.end) - slope_[i]));
    if (tables.c[0] * off * h / scale[i] <= tolerance_) continue;
    const double smooth =
        std::max(std::abs(coefficients_[i][node_count - 1]), std::abs(coefficients_[i][node_count - 2]));
    if (!(off <= node_leap * smooth)) return true;
  }
  return false;
}

Attempt Collocation::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  Attempt attempt;
  const bool grows = !std::exchange(rejected_, true);
  const Outcome outcome = solve(flow, t, h, y, dy, true, out);
  if (outcome == Outcome::not_evaluated)
    return {.evaluated = false, .accepted = false, .next_step = 0.25 * h};
  const Judgement judgement = judge(flow, h);
  const double error = judgement.error;
  attempt.worst = judgement.worst;
  if (judgement.worst >= 0) last_.fall = judgement.fall;
  if (outcome == Outcome::unsettled || std::isnan(error))
    return {.accepted = false, .next_step = 0.5 * h, .worst = attempt.worst};
  last_.known = Known::this_step;
  attempt.accepted = outcome == Outcome::solved && error <= 1;
  double factor = std::pow(aimed_error / std::max(error, 1e-300), 1. / (2 * node_count + 1));
  if (rounds_ > 1) factor = std::min(factor, std::sqrt(aimed_rate / last_.rate));
  factor = std::min(factor, double(aimed_rounds) / rounds_);
  factor = std::clamp(factor, least_shrink, !attempt.accepted ? 0.9 : grows ? most_growth : 1);
  attempt.next_step = h * factor;
  if (!attempt.accepted) return attempt;
  if (!flow.derivative(t + h, out, slope_))
    return {.evaluated = false, .accepted = false, .next_step = 0.25 * h};
  if (leaps_at_an_end(flow, h, dy)) return {.accepted = false, .next_step = 0.5 * h, .worst = attempt.worst};
  last_.known = Known::step_before;
  rejected_ = false;
  return attempt;
}

/// Solves a step by repeated bisection where needed, at most `divisions` times.
bool Collocation::solve_in_parts(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                 const Eigen::VectorXd& dy, int divisions, Eigen::VectorXd& out) {
  const Outcome outcome = solve(flow, t, h, y, dy, false, out);
  if (outcome == Outcome::solved) return true;
  if (outcome == Outcome::not_evaluated || divisions == 0) return false;
  Eigen::VectorXd middle, slope;
  if (!solve_in_parts(flow, t, 0.5 * h, y, dy, divisions - 1, middle)) return false;
  last_.known = Known::nothing;
  return flow.derivative(t + 0.5 * h, middle, slope) &&
         solve_in_parts(flow, t + 0.5 * h, 0.5 * h, middle, slope, divisions - 1, out);
}

bool Collocation::shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                            const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  const Last last = last_;
  kept_ = slopes_;
  last_.known = Known::this_step;
  const bool solved = solve_in_parts(flow, t, h, y, dy, most_divisions, out);
  last_ = last;
  slopes_.swap(kept_);
  return solved;
}

bool Collocation::prepare_dense(Flow&, double, double, const Eigen::VectorXd& y, const Eigen::VectorXd&,
                                const Eigen::VectorXd&) {
  start_ = y;
  return true;
}

void Collocation::interpolate(double theta, Eigen::VectorXd& y) const {
  double weights[node_count];
  for (int i = 0; i < node_count; ++i) {
    weights[i] = 0;
    for (int k = 0; k < node_count; ++k)
      weights[i] += theta * tables.b[k] * tables.lagrange(i, theta * tables.c[k]);
  }
  y = start_;
  for (int i = 0; i < node_count; ++i)
    for (Eigen::Index c = 0; c < y.size(); ++c) y[c] += last_.step * weights[i] * slopes_[c][i];
}

}  // namespace borelli
