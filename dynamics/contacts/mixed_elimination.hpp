// Gaussian elimination of dense equations of which the first are symmetric and positive definite, in blocks
// of eight rows and columns. For contact_solver.cpp: rows that hold a velocity are symmetric, sliding ones
// are not. The functions are static, so that the compiler inlines their only calls.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/numbers/lanes.hpp"

namespace borelli {

namespace mixed_elimination {

inline constexpr int block = Lanes::count;  // pivots and columns per block
inline constexpr int at_once = 4;           // unsymmetric rows per block

/// Multipliers of elimination: for eight columns from `column` on, the entry in each pivot row over the
/// pivot.
template <class L>
static void find_parts(const double* a, int pivots, int stride, int column, double* parts) {
  for (int p = 0; p < pivots; ++p)
    (a[p * stride + p] * L::load(a + p * stride + column)).store(parts + p * block);
}

/// Eliminates the symmetric, positive definite rows in blocks of eight pivots. Each block first subtracts the
/// previous pivot rows, tile by tile of register width, and then eliminates within itself. `bring(k, row)`
/// writes row k when it is needed, and the beginning of the row behind it. `parts`: room for eight numbers
/// per row and one more row. The diagonal ends as the inverse pivot. Returns false if not definite.
template <int width, class Bring>
static bool eliminate_symmetric(double* a, double* parts, int symmetric, int stride, const Bring& bring) {
  using Block = LanesOf<block, width>;
  using Tile = LanesOf<width, width>;
  double* const none = parts + symmetric * block;
  std::fill(none, none + stride, 0.);
  for (int k = 0; k < symmetric; k += block) {
    const int count = std::min(block, symmetric - k);
    double* rows[block];
    for (int l = 0; l < block; ++l) rows[l] = l < count ? a + (k + l) * stride : none;
    for (int l = 0; l < count; ++l) bring(k + l, rows[l]);
    find_parts<Block>(a, k, stride, k, parts);
    const auto take_those_before = [&](int j, Tile* sums) __attribute__((always_inline)) {
      for (int l = 0; l < block; ++l) sums[l] = Tile::load(rows[l] + j);
      for (int p = 0; p < k; ++p) {
        const Tile across = Tile::load(a + p * stride + j);
        const double* const part = parts + p * block;
        for (int l = 0; l < block; ++l) sums[l] -= part[l] * across;
      }
    };
    for (int j = k; j < k + block; j += width) {
      Tile sums[block];
      take_those_before(j, sums);
      for (int l = 0; l < block; ++l) sums[l].store(rows[l] + j);
    }
    double inverse[block] = {}, within[block][block] = {};
    Block pivots[block];
    for (int l = 0; l < block; ++l) pivots[l] = Block::load(rows[l] + k);
#pragma GCC unroll 8
    for (int l = 0; l < block; ++l) {
#pragma GCC unroll 8
      for (int m = 0; m < l; ++m) {
        within[l][m] = pivots[m][l] * inverse[m];
        pivots[l] -= within[l][m] * pivots[m];
      }
      if (l >= count) continue;
      if (!(pivots[l][l] > 0)) return false;
      inverse[l] = 1 / pivots[l][l];
    }
    for (int l = 0; l < block; ++l) pivots[l].store(rows[l] + k);
    for (int j = k + block; j < stride; j += width) {
      Tile sums[block];
      take_those_before(j, sums);
#pragma GCC unroll 8
      for (int l = 1; l < block; ++l) {
#pragma GCC unroll 8
        for (int m = 0; m < l; ++m) sums[l] -= within[l][m] * sums[m];
      }
      for (int l = 0; l < block; ++l) sums[l].store(rows[l] + j);
    }
    for (int l = 0; l < count; ++l) rows[l][k + l] = inverse[l];
  }
  return true;
}

/// Subtracts the symmetric pivot rows from `count` other equations (at_once at most), from column `begin` on.
/// Entries of those equations in the symmetric columns are stored as columns of the symmetric rows, from
/// `column` on.
template <class L>
static void take_symmetric_off(const double* a, int symmetric, int stride, int column, double* parts,
                               int begin, int count, double* after) {
  find_parts<L>(a, symmetric, stride, column, parts);
  for (int j = begin; j < stride; j += block) {
    L sums[at_once];
    for (int r = 0; r < at_once; ++r) sums[r] = L::load(after + std::min(r, count - 1) * stride + j);
    for (int p = 0; p < symmetric; ++p) {
      const L across = L::load(a + p * stride + j);
      for (int r = 0; r < at_once; ++r) sums[r] -= parts[p * block + r] * across;
    }
    for (int r = 0; r < count; ++r) sums[r].store(after + r * stride + j);
  }
}

}  // namespace mixed_elimination

/// Gaussian elimination of n equations in rows of `stride` numbers (a multiple of `block`), right-hand side
/// in column n; x (stride numbers) receives the solution. The first `symmetric` rows and columns are
/// symmetric and positive definite; their part left of the diagonal is not read and may be overwritten.
/// Entries of the other rows in the symmetric columns are stored as columns of the symmetric rows, behind the
/// right-hand side. The other rows are eliminated with column pivoting. `parts`, `bring`: see
/// eliminate_symmetric. Returns false if singular.
template <int width, class Bring>
static bool eliminate_mixed(double* a, int symmetric, int n, int stride, double* parts, double* x,
                            const Bring& bring) {
  using namespace mixed_elimination;
  using L = LanesOf<block, width>;
  if (!eliminate_symmetric<width>(a, parts, symmetric, stride, bring)) return false;
  for (int k = symmetric; k < n; ++k) bring(k, a + k * stride);
  for (int i = symmetric; i < n; i += at_once)
    take_symmetric_off<L>(a, symmetric, stride, n + 1 + i - symmetric, parts, symmetric & ~(block - 1),
                          std::min(at_once, n - i), a + i * stride);
  for (int k = symmetric; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(a[i * stride + k]) > std::abs(a[best * stride + k])) best = i;
    double* const pivot = a + k * stride;
    if (best != k) std::swap_ranges(pivot + k, pivot + stride, a + best * stride + k);
    if (pivot[k] == 0 || !std::isfinite(pivot[k])) return false;
    pivot[k] = 1 / pivot[k];
    for (int i = k + 1; i < n; ++i) {
      double* const row = a + i * stride;
      const double part = row[k] * pivot[k];
      for (int j = k + 1; j <= n; ++j) row[j] -= part * pivot[j];
    }
  }
  std::fill(x, x + stride, 0.);
  for (int begin = (n - 1) & ~(block - 1); begin >= 0; begin -= block) {
    const int end = std::min(begin + block, n);
    double left[block];
    for (int k = begin; k < end; ++k) {
      const double* const row = a + k * stride;
      L sum = 0;
      for (int j = begin + block; j < n; j += block) sum += L::load(row + j) * L::load(x + j);
      left[k - begin] =
          row[n] - (((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7])));
    }
    for (int k = end - 1; k >= begin; --k) {
      x[k] = left[k - begin] * a[k * stride + k];
      for (int i = begin; i < k; ++i) left[i - begin] -= a[i * stride + k] * x[k];
    }
  }
  return true;
}

}  // namespace borelli
