#pragma once

#include <numeric>
#include <vector>

namespace borelli {

/// Numbers 0 to count - 1, each a set of its own at first, in sets that are joined (union-find).
class JoinedSets {
 public:
  explicit JoinedSets(std::size_t count) : leader_(count) { std::iota(leader_.begin(), leader_.end(), 0); }
  /// One number of the set that holds i, the same for all of the set until it is joined to another.
  int find(int i) {
    for (; leader_[i] != i; i = leader_[i]) leader_[i] = leader_[leader_[i]];
    return i;
  }
  void join(int i, int j) { leader_[find(i)] = find(j); }

 private:
  std::vector<int> leader_;
};

}  // namespace borelli
