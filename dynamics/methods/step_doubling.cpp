#include "dynamics/methods/step_doubling.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/numbers/exceeds.hpp"

namespace borelli {

Attempt StepDoubling::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                              const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  const Attempt failed{.evaluated = false, .accepted = false, .next_step = 0.25 * h};
  slope_.resize(y.size());
  if (!method_.attempt(flow, t, h, y, dy, whole_).evaluated) return failed;
  if (!method_.attempt(flow, t, h / 2, y, dy, middle_).evaluated) return failed;
  if (!flow.derivative(t + h / 2, middle_, slope_)) return failed;
  if (!method_.attempt(flow, t + h / 2, h / 2, middle_, slope_, out).evaluated) return failed;

  const Eigen::VectorXd& scale = flow.error_scale();
  const int order = method_.order();
  const double gain = std::pow(2.0, order) - 1;
  Attempt attempt;
  double error = 0;
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    const double difference = out[i] - whole_[i];
    out[i] += difference / gain;
    const double part = std::abs(difference) / scale[i];
    if (exceeds(part, error)) {
      error = part;
      attempt.worst = int(i);
    }
  }
  error /= tolerance_;
  if (!std::isfinite(error)) return failed;
  attempt.accepted = error <= 1;
  // The error goes as h^(order+1). A rejected step is shortened a little more; growth is bounded (Press et
  // al.).
  constexpr double safety = 0.9;
  if (attempt.accepted)
    attempt.next_step = error > 0 ? h * std::min(4.0, safety * std::pow(error, -1.0 / (order + 1))) : 4 * h;
  else
    attempt.next_step = h * std::max(0.1, safety * std::pow(error, -1.0 / order));
  return attempt;
}

}  // namespace borelli
