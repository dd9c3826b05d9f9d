// Before the passes of articulated.cpp: the order in which they visit the joints, and which trees they
// compute side by side.
#include <algorithm>

#include "dynamics/equations/articulated.hpp"
#include "dynamics/equations/articulated_step.hpp"
#include "dynamics/numbers/dual.hpp"
#include "dynamics/numbers/lanes.hpp"

namespace borelli {

using namespace articulated;

template <class T>
ArticulationOf<T>::ArticulationOf(const System& system)
    : links(system.steps.size()), pivots(system.size()), frames(system.bodies.size(), -1) {
  std::vector<char> beside(system.bodies.size(), false);
  if constexpr (std::is_same_v<T, double>)
    for (const AlikeTrees& found : system.alike_trees) {
      for (const AlikeTrees::Each& each : found.bodies)
        for (int b : each) beside[b] = true;
      trees.emplace_back(system, found);
    }
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    frames[b] = body.step_count == 0 ? frames[body.parent] : body.first_step + body.step_count - 1;
    if (body.step_count == 0) every_body_moves = false;
    if (beside[b]) continue;
    alone.push_back(int(b));
    int before = frames[body.parent];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const SwitchStep& step = system.steps[s];
      Joint& joint = joints.emplace_back(Joint{s, before, step.q, step.u, step.drive});
      joint.free_ball =
          step.drive < 0 &&
          std::visit([]<class Kind>(const Kind&) { return turns_freely<Kind>; }, system.parameters.kinds[s]);
      before = s;
    }
    if (body.step_count > 0) joints.back().body = int(b);
  }
  first_swing = joints.size();
  if constexpr (is_lanes<T>) {
    std::vector<char> carries(system.bodies.size(), false);
    for (std::size_t b = 1; b < system.bodies.size(); ++b) carries[system.bodies[b].parent] = true;
    const auto swings = std::ranges::stable_partition(joints, [&](const Joint& joint) {
      return joint.before >= 0 || joint.drive >= 0 || joint.body < 0 || carries[joint.body] ||
             !system.bodies[joint.body].massive ||
             !std::holds_alternative<Rotation>(system.parameters.kinds[joint.step]);
    });
    first_swing = joints.size() - swings.size();
  }
}

SideBySide::SideBySide(const System& system, const AlikeTrees& found) : trees(found) {
  int pivot_count = 0;
  for (std::size_t b = 0; b < trees.bodies.size(); ++b) {
    const AlikeTrees::Each& each = trees.bodies[b];
    bodies.emplace_back().first_step = int(steps.size());
    int before = begins_at_world(system, each[0]) ? by_world : by_carrier;
    if (const int parent = trees.parents[b]; parent >= 0) before = bodies[parent + 1].first_step - 1;
    for (int n = 0; n < system.bodies[each[0]].step_count; ++n) {
      StepOf& step = steps.emplace_back();
      for (std::size_t lane = 0; lane < each.size(); ++lane) {
        step.steps[lane] = system.bodies[each[lane]].first_step + n;
        step.q[lane] = system.steps[step.steps[lane]].q;
        step.u[lane] = system.steps[step.steps[lane]].u;
      }
      step.before = before;
      before = int(steps.size()) - 1;
      step.first_pivot = pivot_count;
      pivot_count += system.steps[step.steps[0]].nv;
    }
  }
  bodies.emplace_back().first_step = int(steps.size());
  pivots.resize(pivot_count);
  const AlikeTrees::Each& first = trees.bodies[0];
  if (steps.size() == 1 && steps[0].before == by_world && system.bodies[first[0]].massive &&
      std::holds_alternative<Rotation>(system.parameters.kinds[steps[0].steps[0]]))
    swings.emplace(steps[0].steps, first);
}

template ArticulationOf<double>::ArticulationOf(const System&);
template ArticulationOf<DualNumber>::ArticulationOf(const System&);
template ArticulationOf<Lanes>::ArticulationOf(const System&);
template ArticulationOf<Quad>::ArticulationOf(const System&);

}  // namespace borelli
