#include "dynamics/system/alike_trees.hpp"

#include <algorithm>
#include <map>

#include "dynamics/system/system.hpp"

namespace borelli {

namespace {

/// Cost of a computation on four bodies side by side, relative to that on one.
constexpr double cost_of_four = 1.4;

/// Depth up to which the cost of splitting subtrees is computed; bounds the recursion.
constexpr int deepest_opened = 1000;

/// The subtrees of a scene, classified by structure (form).
class Forms {
 public:
  explicit Forms(const System& system);

  int count() const { return int(forms_.size()); }
  const std::vector<int>& children(int body) const { return children_[body]; }  ///< equal forms adjacent
  int form(int body) const { return of_[body]; }
  int size(int form) const { return forms_[form].size; }
  bool apart(int form) const { return forms_[form].apart; }

  /// The least cost of `many` subtrees of one form. whole() says whether that takes them side by side as a
  /// whole.
  double cost(int form, int many, int depth = 0) const {
    const double together = cost_together(form, many);
    return depth > deepest_opened ? together : std::min(together, cost_opened(form, many, depth));
  }
  bool whole(int form, int many) const { return cost_together(form, many) <= cost_opened(form, many); }

 private:
  struct Form {
    int size = 1;                          ///< bodies
    bool apart = false;                    ///< contains bodies that cannot be computed side by side
    std::vector<std::pair<int, int>> has;  ///< forms of its children, and how many of each
  };

  double cost_together(int form, int many) const {
    const int packs = many / Quad::count, left = many % Quad::count;
    return forms_[form].size * (cost_of_four * (packs + (left > 1)) + (left == 1));
  }
  double cost_opened(int form, int many, int depth = 0) const {
    double sum = many;
    for (const auto& [child, times] : forms_[form].has) sum += cost(child, many * times, depth + 1);
    return sum;
  }

  std::vector<int> of_;
  std::vector<std::vector<int>> children_;
  std::vector<Form> forms_;
};

Forms::Forms(const System& system) : of_(system.bodies.size(), -1), children_(system.bodies.size()) {
  std::map<std::vector<int>, int> known;
  for (int b = int(system.bodies.size()) - 1; b > 0; --b) {
    const Body& body = system.bodies[b];
    std::ranges::stable_sort(children_[b], {}, [&](int child) { return of_[child]; });
    Form form;
    std::vector<int> key{body.step_count, body.massive, body.touched};
    form.apart = body.step_count == 0;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      key.push_back(int(system.parameters.kinds[s].index()));
      key.push_back(system.parameters.armatures[s] == 0);
      const bool bends =
          std::visit([]<class Kind>(const Kind&) { return Bending<Kind>; }, system.parameters.kinds[s]);
      if (system.steps[s].drive >= 0 || bends) form.apart = true;
    }
    key.push_back(form.apart);
    for (int child : children_[b]) {
      const int of = of_[child];
      key.push_back(of);
      form.size += forms_[of].size;
      form.apart = form.apart || forms_[of].apart;
      if (!form.has.empty() && form.has.back().first == of)
        ++form.has.back().second;
      else
        form.has.emplace_back(of, 1);
    }
    const auto [at, is_new] = known.try_emplace(key, int(forms_.size()));
    if (is_new) forms_.push_back(form);
    of_[b] = at->second;
    children_[body.parent].push_back(b);
  }
}

/// Lays the subtrees of these roots side by side.
AlikeTrees side_by_side(const Forms& forms, const std::vector<int>& roots) {
  AlikeTrees trees;
  trees.count = int(roots.size());
  AlikeTrees::Each first;
  for (std::size_t lane = 0; lane < first.size(); ++lane) first[lane] = roots[lane < roots.size() ? lane : 0];
  trees.bodies.push_back(first);
  trees.parents.push_back(-1);
  for (std::size_t i = 0; i < trees.bodies.size(); ++i) {
    const AlikeTrees::Each carriers = trees.bodies[i];
    for (std::size_t child = 0; child < forms.children(carriers[0]).size(); ++child) {
      AlikeTrees::Each each;
      for (std::size_t lane = 0; lane < each.size(); ++lane)
        each[lane] = forms.children(carriers[lane])[child];
      trees.bodies.push_back(each);
      trees.parents.push_back(int(i));
    }
  }
  return trees;
}

}  // namespace

bool begins_at_world(const System& system, int b) {
  do b = system.bodies[b].parent;
  while (b > 0 && system.bodies[b].step_count == 0);
  return b == 0;
}

std::vector<AlikeTrees> find_alike_trees(const System& system) {
  const Forms forms(system);
  std::vector<int> by_size(forms.count());
  for (int form = 0; form < forms.count(); ++form) by_size[form] = form;
  std::ranges::stable_sort(by_size, std::greater{}, [&](int form) { return forms.size(form); });

  std::vector<std::vector<int>> members(forms.count());
  for (std::size_t b = 1; b < system.bodies.size(); ++b) members[forms.form(int(b))].push_back(int(b));

  std::vector<AlikeTrees> out;
  std::vector<char> taken(system.bodies.size(), false);
  for (int form : by_size) {
    if (forms.apart(form)) continue;
    // subtrees on the world are computed differently from carried ones
    for (const bool at_world : {true, false}) {
      std::vector<int> roots;
      for (int b : members[form])
        if (!taken[b] && begins_at_world(system, b) == at_world) roots.push_back(b);
      if (roots.size() < 2 || !forms.whole(form, int(roots.size()))) continue;
      for (std::size_t begin = 0; begin + 1 < roots.size(); begin += Quad::count) {
        const auto from = roots.begin() + std::ptrdiff_t(begin);
        const auto count = std::min<std::ptrdiff_t>(Quad::count, roots.end() - from);
        out.push_back(side_by_side(forms, {from, from + count}));
        for (const AlikeTrees::Each& each : out.back().bodies)
          for (int body : each) taken[body] = true;
      }
    }
  }
  return out;
}

}  // namespace borelli
