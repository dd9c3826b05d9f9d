#include "dynamics/coordinate_layout.hpp"

#include <algorithm>

namespace borelli {

void lay_out_coordinates(System& system, const std::vector<std::vector<int>>& chains,
                         const std::vector<int>& previous) {
  for (Step& step : system.steps)
    if (step.drive >= 0) {
      step.q += system.nq;
      step.u += system.nv;
    }
  const int size = system.size();
  for (std::size_t b = 0; b < system.bodies.size(); ++b) {
    Body& body = system.bodies[b];
    body.first_support = int(system.support.size());
    for (int s : chains[b])
      for (int i = 0; i < system.steps[s].nv; ++i) system.support.push_back(system.steps[s].u + i);
    body.support_count = int(system.support.size()) - body.first_support;
    const int* support = system.support.data() + body.first_support;
    int own = 0;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) own += system.steps[s].nv;
    for (int i = body.support_count - own; i < body.support_count; ++i)
      for (int j = 0; j <= i; ++j)
        system.pattern.push_back(std::max(support[i], support[j]) * size + std::min(support[i], support[j]));
  }
  // (each is there once, since a coordinate is one body's own)
  std::sort(system.pattern.begin(), system.pattern.end());

  std::vector<int> parent(system.nv, -1);  // of each free coordinate, the free one before it
  for (std::size_t s = 0; s < system.steps.size(); ++s) {
    const Step& step = system.steps[s];
    if (step.drive >= 0) continue;
    const int before = previous[s];
    parent[step.u] = before < 0 ? -1 : system.steps[before].u + system.steps[before].nv - 1;
    for (int i = 1; i < step.nv; ++i) parent[step.u + i] = step.u + i - 1;
  }
  for (int u = 0; u < system.nv; ++u) {
    system.first_ancestor.push_back(int(system.ancestors.size()));
    for (int i = parent[u]; i >= 0; i = parent[i]) system.ancestors.push_back(i);
    std::reverse(system.ancestors.begin() + system.first_ancestor.back(), system.ancestors.end());
  }
  system.first_ancestor.push_back(int(system.ancestors.size()));
}

}  // namespace borelli
