// Sparse rows, and the Cholesky factor of their Gram matrix, W W^T = R R^T, with any pivot order. For many
// loops, each tied only to its neighbours, the order of next() makes the cost nearly linear in their number.
//
// What elimination leaves of a row's squared length is its squared distance from the rows before it. Rounding
// of the full length limits that, so near dependence another method decides (ConstraintSolver).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

class SparseRows {
 public:
  explicit SparseRows(const System& system);

  /// The free columns in which row r can have entries, ascending, with their ancestors on the branches.
  std::span<const int> columns(int r) const {
    const Range& range = ranges_[constraint_[r]];
    return {columns_.data() + range.first, std::size_t(range.count)};
  }
  /// Row r's numbers in these columns. Write them all, or clear the row, before use.
  double* row(int r) { return numbers_.data() + first_[r]; }
  void clear(int r);
  /// Row r <- F^-T (row r) (branch_sparse.hpp).
  void measure(const System& system, const Rows& F, int r);

  double dot(int r, const double* x) const;  ///< row r . x; x: nv numbers
  /// The same for row r of L, which has entries in these columns only.
  double dot(const Rows& L, int r, const double* x) const;
  void add_to(double* x, double factor, int r) const;  ///< x += factor times row r

  /// Computes the Gram matrix and begins the factor. `ordered`: next() chooses the order.
  void multiply(bool ordered);
  /// Squared distance of row r from the eliminated rows; `gone` for an eliminated row.
  double left(int r) const { return left_[r]; }
  static constexpr double gone = -1;
  /// The next pivot row. Candidates keep at least a millionth of the largest remaining square. Takes one that
  /// changes the fewest other rows (Markowitz, Management Science 3, 1957), then the farthest, then, within
  /// 1e-6, the first. -1: no row has a valid remainder. Rows must have length 1 at most.
  int next();
  /// Eliminates a row with a positive remainder as the next of the factor.
  void eliminate(int row);
  /// A column of R: the pivot row first, then rows eliminated later or never.
  struct Entry {
    int row;
    double value;
  };
  std::span<const Entry> column(int k) const {
    return {entries_.data() + first_entry_[k], std::size_t(first_entry_[k + 1] - first_entry_[k])};
  }
  /// b <- R^-1 b and b <- R^-T b over the eliminated rows; b is indexed by row.
  void solve_lower(double* b) const;
  void solve_upper(double* b) const;

 private:
  struct Range {
    int first = 0, count = 0;
  };

  /// A block of consecutive rows and the greatest of their claims.
  struct Block {
    static constexpr int rows = 64;
    bool known = false;
    double claim = 0;
  };

  void find_neighbours();
  void relate(int i, int j, double product);
  void make_claim(int row);
  double greatest_claim();

  std::vector<int> constraint_, first_;  ///< per row: its constraint; offset of its numbers
  std::vector<Range> ranges_;            ///< per constraint: its columns (ranges_) and rows (rows_)
  std::vector<Range> rows_;
  std::vector<int> columns_, first_neighbour_,
      neighbours_;                        ///< per constraint, those that share a column: itself, later ones
  std::vector<double> numbers_, spread_;  ///< spread_: nv numbers, zero between uses
  int words_;
  Rows products_;                         ///< rows x rows: products of a row with later related ones
  std::vector<std::uint64_t> relatives_;  ///< bit mask, words_ per row: rows with a nonzero product
  std::vector<int> degree_;               ///< per row: number of these
  std::vector<double> left_;
  std::vector<double> claim_;  ///< per row, its rank as next pivot: greater for fewer changed rows, then for
                               ///< a larger remainder; no claim below enough_
  std::vector<Block> blocks_;
  double enough_ = 0;
  bool ordered_ = true;
  std::vector<Entry> entries_;
  std::vector<int> first_entry_;
};

}  // namespace borelli
