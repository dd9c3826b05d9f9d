#include "dynamics/contacts/contact_choice.hpp"

#include <algorithm>

namespace borelli {

using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

// `small`: part of the acceleration scale that counts as zero; `at_the_limit`: relative distance from the
// friction limit that counts as reaching it.
constexpr double small = 1e-9, at_the_limit = 1e-6;

ContactMode mode_of(const Shock& contacts, const ShockResult& result, int i, const Vector2d& at_limit,
                    double scale) {
  const double normal = result.impulse[3 * i], friction = contacts.surfaces[i].friction;
  ContactMode mode;
  if (normal * contacts.response(3 * i, 3 * i) <= small * scale) return mode;
  mode.touch = Touch::sliding;
  const double mobility =
      std::max(contacts.response(3 * i + 1, 3 * i + 1), contacts.response(3 * i + 2, 3 * i + 2));
  if (friction == 0 || mobility == 0) return mode;
  const Vector2d force = result.impulse.segment<2>(3 * i + 1), moves = result.velocity.segment<2>(3 * i + 1);
  Vector2d slip = contacts.slip[i];
  if (slip.squaredNorm() == 0 && force.norm() >= (1 - at_the_limit) * friction * normal) {
    if (moves.norm() > small * scale)
      slip = moves.normalized();
    else
      slip = at_limit;
  }
  if (slip.squaredNorm() == 0)
    mode.touch = Touch::sticking;
  else
    for (int k = 0; k < 2; ++k) mode.slip[k] = slip[k];
  return mode;
}

}  // namespace

Choice choose_modes(const Shock& contacts, const std::vector<Vector2d>& slip_at_limit, double gravity) {
  const int n = int(contacts.surfaces.size());
  const ShockResult result = press(contacts);
  Choice out{.settled = result.settled, .jammed = -1, .modes = {}};
  double scale = gravity;
  for (int i = 0; i < n; ++i) scale = std::max(scale, std::abs(contacts.velocity[3 * i]));
  if (result.jammed >= 0 && result.velocity[3 * result.jammed] < -small * scale) out.jammed = result.jammed;
  for (int i = 0; i < n; ++i) out.modes.push_back(mode_of(contacts, result, i, slip_at_limit[i], scale));
  return out;
}

}  // namespace borelli
