// The rooted trees of order conditions: a Runge-Kutta method is of order p if, for each tree of at most p
// nodes, the sum of weights times the tree's stage products is 1 / gamma (Butcher 1963; Hairer, Norsett,
// Wanner, Solving ODEs I, theorem II.2.13).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace borelli::test {

struct RootedTree {
  int nodes = 1;
  double density = 1;         ///< gamma: nodes times the densities of the branches
  std::vector<int> branches;  ///< trees of the list with fewer nodes, ascending
};

/// All rooted trees with at most `most` nodes: 1, 2, 4, 8, 17, 37, 85, 200 for 1 to 8 nodes.
inline std::vector<RootedTree> rooted_trees(int most) {
  std::vector<RootedTree> trees{{}};
  for (int nodes = 2; nodes <= most; ++nodes) {
    const std::vector<RootedTree> smaller = trees;
    // ascending choices of smaller trees with nodes - 1 nodes in all
    const auto extend = [&](auto&& self, RootedTree tree, int first) -> void {
      if (tree.nodes == nodes) {
        tree.density *= nodes;
        trees.push_back(tree);
        return;
      }
      for (int i = first; i < int(smaller.size()); ++i) {
        if (tree.nodes + smaller[i].nodes > nodes) continue;
        RootedTree more = tree;
        more.nodes += smaller[i].nodes;
        more.density *= smaller[i].density;
        more.branches.push_back(i);
        self(self, more, i);
      }
    };
    extend(extend, RootedTree{}, 0);
  }
  return trees;
}

/// Per tree, its stage products for the coupling matrix A (stages x stages).
inline std::vector<Eigen::VectorXd> stage_products(const std::vector<RootedTree>& trees,
                                                   const Eigen::MatrixXd& A) {
  std::vector<Eigen::VectorXd> products;
  for (const RootedTree& tree : trees) {
    Eigen::VectorXd product = Eigen::VectorXd::Ones(A.rows());
    for (int branch : tree.branches) product.array() *= (A * products[branch]).array();
    products.push_back(product);
  }
  return products;
}

/// The largest violation of the conditions up to order `order` by weights b that step to theta.
inline double order_violation(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, int order,
                              double theta = 1) {
  const auto trees = rooted_trees(order);
  const auto products = stage_products(trees, A);
  double worst = 0;
  for (std::size_t i = 0; i < trees.size(); ++i)
    worst =
        std::max(worst, std::abs(b.dot(products[i]) - std::pow(theta, trees[i].nodes) / trees[i].density));
  return worst;
}

}  // namespace borelli::test
