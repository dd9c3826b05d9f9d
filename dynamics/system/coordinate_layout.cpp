#include "dynamics/system/coordinate_layout.hpp"

#include <algorithm>

namespace borelli {

void lay_out_coordinates(System& system) {
  for (SwitchStep& step : system.steps)
    if (step.drive >= 0) {
      step.q += system.nq;
      step.u += system.nv;
    }
  std::ptrdiff_t before = 0;
  for (std::size_t b = 0; b < system.bodies.size(); ++b) {
    Body& body = system.bodies[b];
    body.first_support = before;
    body.support_count = b == 0 ? 0 : system.bodies[body.parent].support_count;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s)
      body.support_count += system.steps[s].nv;
    before += body.support_count;
  }
}

double Branches::bytes(const System& system) {
  double numbers = 0;
  for (const Body& body : system.bodies) {
    numbers += body.support_count;
    // each own coordinate has all those before it as ancestors
    const int own = body.support_count - system.bodies[body.parent].support_count;
    if (&body != system.bodies.data()) numbers += double(own) * body.support_count;
  }
  return sizeof(int) * numbers;
}

namespace {

Branches branches_of(const System& system) {
  Branches out;
  out.support.reserve(std::size_t(system.bodies.back().first_support + system.bodies.back().support_count));
  std::vector<int> parent(system.nv, -1);                // per free coordinate, the free one before it
  std::vector<int> last_free(system.bodies.size(), -1);  // per body, the last free one on its chain
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    const Body& carrier = system.bodies[body.parent];
    for (int i = 0; i < carrier.support_count; ++i)
      out.support.push_back(out.support[std::size_t(carrier.first_support + i)]);
    int& last = last_free[b] = last_free[body.parent];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const SwitchStep& step = system.steps[s];
      for (int u = step.u; u < step.u + step.nv; ++u) {
        out.support.push_back(u);
        if (step.drive >= 0) continue;
        parent[u] = last;
        last = u;
      }
    }
  }
  for (int u = 0; u < system.nv; ++u) {
    const auto first = std::ptrdiff_t(out.ancestors.size());
    out.first_ancestor.push_back(first);
    for (int i = parent[u]; i >= 0; i = parent[i]) out.ancestors.push_back(i);
    std::reverse(out.ancestors.begin() + first, out.ancestors.end());
  }
  out.first_ancestor.push_back(std::ptrdiff_t(out.ancestors.size()));
  return out;
}

}  // namespace

const Branches& BranchesOnDemand::lay_out(const System& system) const {
  const std::lock_guard alone(shared_->at_work);
  if (!shared_->ready.load(std::memory_order_relaxed)) {
    shared_->branches = branches_of(system);
    shared_->ready.store(&shared_->branches, std::memory_order_release);
  }
  return shared_->branches;
}

}  // namespace borelli
