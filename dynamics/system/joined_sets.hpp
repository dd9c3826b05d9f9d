#pragma once

#include <numeric>
#include <vector>

namespace borelli {

/// Disjoint sets of the numbers 0 to count - 1 (union-find). Each number starts as a set of its own.
class JoinedSets {
 public:
  explicit JoinedSets(std::size_t count) : leader_(count) { std::iota(leader_.begin(), leader_.end(), 0); }
  /// The leader of the set of i: two numbers are in one set if they have the same leader.
  int find(int i) {
    for (; leader_[i] != i; i = leader_[i]) leader_[i] = leader_[leader_[i]];
    return i;
  }
  void join(int i, int j) { leader_[find(i)] = find(j); }

 private:
  std::vector<int> leader_;
};

}  // namespace borelli
