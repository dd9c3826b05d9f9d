#include "dynamics/equations/branch_sparse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

namespace {

struct Branch {
  const int* ancestors;
  int count;
};

Branch branch_of(const Branches& all, int k) {
  const std::ptrdiff_t first = all.first_ancestor[k];
  return {all.ancestors.data() + first, int(all.first_ancestor[k + 1] - first)};
}

/// One step of F^-T x, for coordinate k.
void take_from_ancestors(const Branches& branches, const Rows& F, int k, double* x) {
  if (x[k] == 0) return;
  const Branch branch = branch_of(branches, k);
  const double* row = F.row(k).data();
  x[k] /= row[k];
  for (int a = 0; a < branch.count; ++a) x[branch.ancestors[a]] -= row[branch.ancestors[a]] * x[k];
}

// Compact rows are used if all fit into the first-level cache.
constexpr int most_in_cache = 2048;

/// The smallest pivot so far, against its diagonal entry.
struct SmallestPivot {
  double ratio = 1, pivot = 0;
  int k = -1;

  /// Takes the next pivot. Returns false if it is within the rounding error of its diagonal entry.
  bool note(int k_now, double pivot_now, double before) {
    if (!(pivot_now > 1e-14 * before)) return false;
    if (pivot_now < ratio * before) *this = {pivot_now / before, pivot_now, k_now};
    return true;
  }

  /// Whether the pivot is more than its rounding error, which is about eps z^T |A| z, with eps = 2^-52. Here z_k = 1, and z_j is the
  /// velocity of coordinate j > k if it follows k freely. A pivot above 1e-7 of its diagonal entry passes
  /// unchecked: its error could be as large only if some z_j were in the thousands. Stores z in F's row k, right of
  /// the diagonal, which the factor does not use.
  bool exceeds_rounding(const Branches& branches, int n, const Rows& A, Rows& F) const {
    if (ratio > 1e-7) return true;
    double* const z = F.row(k).data();
    double size = A(k, k);
    for (int j = k + 1; j < n; ++j) {
      const Branch branch = branch_of(branches, j);
      const double* const row = F.row(j).data();
      double follows = 0, beside = 0;
      for (int a = 0; a < branch.count; ++a) {
        const int i = branch.ancestors[a];
        if (i < k) continue;
        const double z_i = i == k ? 1 : z[i];
        follows -= row[i] * z_i;
        beside += std::abs(A(j, i) * z_i);
      }
      z[j] = follows / row[j];
      size += std::abs(z[j]) * (2 * beside + A(j, j) * std::abs(z[j]));
    }
    return pivot > 16 * std::numeric_limits<double>::epsilon() * size;
  }
};

/// Factors a tree of short branches with compact rows that hold only the entries along their branch. The
/// branch of an ancestor is a prefix of the row's own branch, so elimination subtracts prefixes of rows.
/// `stride`: room per row, in whole registers.
int factor_short(const System& system, const Branches& branches, const Rows& A, Rows& F, int stride) {
  using L = LanesOf<2, 2>;  // width that every processor has: the same results on all
  alignas(64) double rows[most_in_cache];
  const int n = system.nv;
  for (int k = 0; k < n; ++k) {
    const Branch branch = branch_of(branches, k);
    const double* const from = A.row(k).data();
    double* const row = rows + k * stride;
    for (int a = branch.count & ~(L::count - 1); a < stride; a += L::count) L(0).store(row + a);
    for (int a = 0; a < branch.count; ++a) row[a] = from[branch.ancestors[a]];
    row[branch.count] = from[k];
  }
  SmallestPivot smallest;
  for (int k = n - 1; k >= 0; --k) {
    const Branch branch = branch_of(branches, k);
    double *const row = rows + k * stride, *const to = F.row(k).data();
    if (!smallest.note(k, row[branch.count], A(k, k))) return k;
    to[k] = std::sqrt(row[branch.count]);
    const double inverse = 1 / to[k];
    for (int a = 0; a < branch.count; a += L::count) (inverse * L::load(row + a)).store(row + a);
    for (int a = 0; a < branch.count; ++a) {
      const double part = row[a];
      double* const other = rows + branch.ancestors[a] * stride;
      for (int b = 0; b <= a; b += L::count) (L::load(other + b) - part * L::load(row + b)).store(other + b);
      to[branch.ancestors[a]] = part;
    }
  }
  return smallest.exceeds_rounding(branches, n, A, F) ? -1 : smallest.k;
}

}  // namespace

int factor_mass_matrix(const System& system, const Rows& A, Rows& F) {
  const Branches& branches = system.branches();
  const int n = system.nv;
  int longest = 0;
  for (int k = 0; k < n; ++k) longest = std::max(longest, branch_of(branches, k).count);
  if (const int stride = (longest + 2) & ~1; n * stride <= most_in_cache)
    return factor_short(system, branches, A, F, stride);
  for (int k = 0; k < n; ++k) {
    const Branch branch = branch_of(branches, k);
    for (int a = 0; a < branch.count; ++a) F(k, branch.ancestors[a]) = A(k, branch.ancestors[a]);
    F(k, k) = A(k, k);
  }
  SmallestPivot smallest;
  for (int k = n - 1; k >= 0; --k) {
    const Branch branch = branch_of(branches, k);
    double* row = F.row(k).data();
    if (!smallest.note(k, row[k], A(k, k))) return k;
    const double pivot = std::sqrt(row[k]), inverse = 1 / pivot;
    row[k] = pivot;
    for (int a = 0; a < branch.count; ++a) row[branch.ancestors[a]] *= inverse;
    const bool dense =
        branch.count > 0 && branch.ancestors[branch.count - 1] - branch.ancestors[0] + 1 == branch.count;
    for (int a = 0; a < branch.count; ++a) {
      const int i = branch.ancestors[a];
      double* other = F.row(i).data();
      const double c = row[i];
      if (dense)
        for (int j = branch.ancestors[0]; j <= i; ++j) other[j] -= c * row[j];
      else
        for (int b = 0; b <= a; ++b) other[branch.ancestors[b]] -= c * row[branch.ancestors[b]];
    }
  }
  return smallest.exceeds_rounding(branches, n, A, F) ? -1 : smallest.k;
}

void solve_transposed(const System& system, const Rows& F, double* x) {
  const Branches& branches = system.branches();
  for (int k = system.nv - 1; k >= 0; --k) take_from_ancestors(branches, F, k, x);
}

void solve_transposed(const System& system, const Rows& F, std::span<const int> coordinates, double* x) {
  const Branches& branches = system.branches();
  for (std::size_t i = coordinates.size(); i-- > 0;) take_from_ancestors(branches, F, coordinates[i], x);
}

namespace {

template <class L>
int solve_transposed_lanes(const System& system, const Rows& F, double* x, Eigen::Index stride, int* rows) {
  const Branches& branches = system.branches();
  int count = 0;
  for (int k = system.nv - 1; k >= 0; --k) {
    L each = L::load(x + k * stride);
    if (everywhere(each == 0)) continue;
    rows[count++] = k;
    const Branch branch = branch_of(branches, k);
    const double* row = F.row(k).data();
    each /= row[k];
    each.store(x + k * stride);
    for (int a = 0; a < branch.count; ++a) {
      double* const other = x + branch.ancestors[a] * stride;
      (L::load(other) - row[branch.ancestors[a]] * each).store(other);
    }
  }
  return count;
}

}  // namespace

int solve_transposed(const System& system, const Rows& F, double* x, Eigen::Index stride, int* rows) {
  return in_registers(
      []<int width>(auto&... each) { return solve_transposed_lanes<LanesOf<Lanes::count, width>>(each...); },
      system, F, x, stride, rows);
}

namespace {

/// x <- F^-T x for a block of columns and the same of the matrix beside.
template <class L>
void solve_transposed_pair(const Branches& branches, const Rows& F, const RowPattern& pattern, int block,
                           double* x, Eigen::Index apart, Eigen::Index stride) {
  for (int k = int(F.rows()) - 1; k >= 0; --k) {
    if (!pattern.holds(block, k)) continue;
    const Branch branch = branch_of(branches, k);
    const double* row = F.row(k).data();
    double* const own = x + k * stride;
    const L inverse = 1 / row[k], left = inverse * L::load(own), right = inverse * L::load(own + apart);
    left.store(own);
    right.store(own + apart);
    for (int a = 0; a < branch.count; ++a) {
      const L factor = row[branch.ancestors[a]];
      double* const other = x + branch.ancestors[a] * stride;
      (L::load(other) - factor * left).store(other);
      (L::load(other + apart) - factor * right).store(other + apart);
    }
  }
}

/// x <- scale F^-1 x for N registers of columns: as many sums at once hide the latency of an addition.
template <int N, class L>
void solve_lower_blocks(const Branches& branches, const Rows& F, double scale, double* x,
                        Eigen::Index stride) {
  for (int k = 0; k < int(F.rows()); ++k) {
    const Branch branch = branch_of(branches, k);
    const double* row = F.row(k).data();
    double* const own = x + k * stride;
    L sum[N];
    for (int n = 0; n < N; ++n) sum[n] = scale * L::load(own + n * L::count);
    for (int a = 0; a < branch.count; ++a) {
      const L factor = row[branch.ancestors[a]];
      const double* const other = x + branch.ancestors[a] * stride;
      for (int n = 0; n < N; ++n) sum[n] -= factor * L::load(other + n * L::count);
    }
    const L inverse = 1 / row[k];
    for (int n = 0; n < N; ++n) (sum[n] * inverse).store(own + n * L::count);
  }
}

template <class L>
void solve_pair_lanes(const System& system, const Rows& F, const RowPattern& pattern, double scale, double* x,
                      Eigen::Index stride) {
  const Branches& branches = system.branches();
  const int blocks = pattern.blocks(), columns = 2 * blocks * L::count;
  for (int block = 0; block < blocks; ++block)
    solve_transposed_pair<L>(branches, F, pattern, block, x + block * L::count, blocks * L::count, stride);
  int first = 0;
  for (; first + 4 * L::count <= columns; first += 4 * L::count)
    solve_lower_blocks<4, L>(branches, F, scale, x + first, stride);
  if (first < columns) solve_lower_blocks<2, L>(branches, F, scale, x + first, stride);
}

}  // namespace

RowPattern::RowPattern(const System& system)
    : reached_(RowsOf<char>::Zero((system.nv + Lanes::count - 1) / Lanes::count, system.nv)) {
  const Branches& branches = system.branches();
  for (int i = 0; i < system.nv; ++i) {
    add(system, i, i);
    const Branch branch = branch_of(branches, i);
    for (int a = 0; a < branch.count; ++a) reached_(branch.ancestors[a] / Lanes::count, i) = 1;
  }
}

void RowPattern::add(const System& system, int i, int j) {
  char* const reached = reached_.row(j / Lanes::count).data();
  const Branch branch = branch_of(system.branches(), i);
  reached[i] = 1;
  for (int a = 0; a < branch.count; ++a) reached[branch.ancestors[a]] = 1;
}

void solve_pair(const System& system, const Rows& F, const RowPattern& pattern, double scale, double* x,
                Eigen::Index stride) {
  in_registers([]<int width>(auto&... each) { solve_pair_lanes<LanesOf<Lanes::count, width>>(each...); },
               system, F, pattern, scale, x, stride);
}

void solve_lower(const System& system, const Rows& F, double* x) {
  const Branches& branches = system.branches();
  for (int k = 0; k < system.nv; ++k) {
    const Branch branch = branch_of(branches, k);
    const double* row = F.row(k).data();
    double sum = x[k];
    for (int a = 0; a < branch.count; ++a) sum -= row[branch.ancestors[a]] * x[branch.ancestors[a]];
    x[k] = sum / row[k];
  }
}

}  // namespace borelli
