// Rows over the few columns that they can have entries in, and the factor of their Gram matrix, W W^T = R
// R^T, by Cholesky's elimination in any order: for many loops, each tied to its neighbours only, as good as
// linear in their number, in the order that next() finds.
//
// What is left of a row's square shows its distance from those before it, to rounding over that square: so
// near dependence others must decide (ConstraintSolver).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

class SparseRows {
 public:
  explicit SparseRows(const System& system);

  /// The free columns that row r can have entries in, ascending, with those before them on their branches.
  std::span<const int> columns(int r) const {
    const Range& range = ranges_[constraint_[r]];
    return {columns_.data() + range.first, std::size_t(range.count)};
  }
  /// Row r's numbers in these columns: to be written whole, or cleared, before the rows are used.
  double* row(int r) { return numbers_.data() + first_[r]; }
  void clear(int r);
  /// Row r <- F^-T times it (branch_sparse.hpp).
  void measure(const System& system, const Rows& F, int r);

  double dot(int r, const double* x) const;  ///< row r . x; x: nv numbers
  /// The same of another matrix's row r, which has entries in these columns only.
  double dot(const Rows& L, int r, const double* x) const;
  void add_to(double* x, double factor, int r) const;  ///< x += factor times row r

  /// Begins the factor: the Gram matrix. `ordered`: by next().
  void multiply(bool ordered);
  /// The square of what is left of row r beside those eliminated; of a row eliminated: `gone`.
  double left(int r) const { return left_[r]; }
  static constexpr double gone = -1;
  /// Of rows of length 1 at most, and of those of which most is left, to a millionth of its square, one that
  /// changes the fewest others (Markowitz, Management Science 3, 1957); of these the farthest, of rows
  /// equally far, to 1e-6, the first. -1: of none is it a number.
  int next();
  /// Makes a row, of which something is left, the next of the factor.
  void eliminate(int row);
  /// A column of R: its row itself first, then those eliminated later or never.
  struct Entry {
    int row;
    double value;
  };
  std::span<const Entry> column(int k) const {
    return {entries_.data() + first_entry_[k], std::size_t(first_entry_[k + 1] - first_entry_[k])};
  }
  /// b <- R^-1 b and b <- R^-T b over the rows eliminated; b by rows.
  void solve_lower(double* b) const;
  void solve_upper(double* b) const;

 private:
  struct Range {
    int first = 0, count = 0;
  };

  /// So many rows one after the other, and the greatest of their claims.
  struct Block {
    static constexpr int rows = 64;
    bool known = false;
    double claim = 0;
  };

  void find_neighbours();
  void relate(int i, int j, double product);
  void make_claim(int row);
  double greatest_claim();

  std::vector<int> constraint_, first_;  ///< of each row; where its numbers begin
  std::vector<Range> ranges_;            ///< of each constraint: its columns, and its rows
  std::vector<Range> rows_;
  std::vector<int> columns_, first_neighbour_,
      neighbours_;                        ///< constraints that share a column: itself, later ones
  std::vector<double> numbers_, spread_;  ///< (spread_: nv zeros)
  int words_;
  Rows products_;                         ///< rows x rows, of a row with later ones, where related
  std::vector<std::uint64_t> relatives_;  ///< words_ per row: which rows have a product with it
  std::vector<int> degree_;               ///< of each row: how many these are
  std::vector<double> left_;
  std::vector<double> claim_;  ///< of each row to be the next: the greater, the fewer it changes, and the
                               ///< more is left of it; none where that is not enough_
  std::vector<Block> blocks_;
  double enough_ = 0;
  bool ordered_ = true;
  std::vector<Entry> entries_;
  std::vector<int> first_entry_;
};

}  // namespace borelli
