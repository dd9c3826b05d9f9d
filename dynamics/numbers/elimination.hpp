// Small systems of linear equations, solved in place and without allocation.
#pragma once

#include <cmath>
#include <utility>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// Solves M x = b in place for the leading n x n block: x holds b on entry. Gaussian elimination with partial
/// (row) pivoting; overwrites M.
inline void eliminate(RowsOf<double>& M, Eigen::VectorXd& x, int n) {
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(M(i, k)) > std::abs(M(pivot, k))) pivot = i;
    M.row(k).head(n).swap(M.row(pivot).head(n));
    std::swap(x[k], x[pivot]);
    for (int i = k + 1; i < n; ++i) {
      const double c = M(i, k) / M(k, k);
      for (int j = k; j < n; ++j) M(i, j) -= c * M(k, j);
      x[i] -= c * x[k];
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    for (int j = k + 1; j < n; ++j) x[k] -= M(k, j) * x[j];
    x[k] /= M(k, k);
  }
}

}  // namespace borelli
