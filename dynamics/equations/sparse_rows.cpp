#include "dynamics/equations/sparse_rows.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

namespace {

// Least remainder of a candidate, relative to the largest squared remainder. It is small because near a
// singular position many rows have small remainders; left to the end, they would all be coupled.
constexpr double far_enough = 1e-6;

constexpr double no_claim = -std::numeric_limits<double>::infinity();

/// Marks the free columns that an action's sites and coordinates depend on, closed under ancestors.
void mark_columns(const System& system, const Action& action, std::vector<char>& marked) {
  const Branches& branches = system.branches();
  const auto mark = [&](int u) {
    if (u < 0 || u >= system.nv || marked[u]) return;
    marked[u] = 1;
    for (auto a = branches.first_ancestor[u]; a < branches.first_ancestor[u + 1]; ++a)
      marked[branches.ancestors[a]] = 1;
  };
  for (int i = 0; i < action.site_count; ++i) {
    const int at = system.sites[action.first_site + i].body;
    if (at < 0) continue;
    const Body& body = system.bodies[at];
    for (int s = 0; s < body.support_count; ++s) mark(branches.support[body.first_support + s]);
  }
  for (int i = 0; i < action.coordinate_count; ++i)
    mark(system.coordinate_sites[action.first_coordinate + i].u);
}

}  // namespace

SparseRows::SparseRows(const System& system)
    : constraint_(system.row_constraint),
      spread_(system.nv, 0.0),
      words_((system.rows + 63) / 64),
      relatives_(std::size_t(system.rows) * words_, 0),
      degree_(system.rows, 0),
      left_(system.rows, 0.0),
      claim_(left_),
      blocks_((system.rows + Block::rows - 1) / Block::rows) {
  std::vector<char> marked(system.nv);
  int numbers = 0;
  for (const Action& action : system.constraints) {
    std::fill(marked.begin(), marked.end(), 0);
    mark_columns(system, action, marked);
    const int first = int(columns_.size());
    for (int u = 0; u < system.nv; ++u)
      if (marked[u]) columns_.push_back(u);
    const int count = int(columns_.size()) - first;
    ranges_.push_back({first, count});
    rows_.push_back({action.first_row, action.row_count});
    for (int r = 0; r < action.row_count; ++r) {
      first_.push_back(numbers);
      numbers += count;
    }
  }
  numbers_.assign(numbers, 0.0);
  // (With contacts this waits for first use: methods that handle contacts themselves never need it.)
  if (system.contacts.empty()) find_neighbours();
  first_entry_.reserve(system.rows + 1);
  entries_.reserve(std::size_t(system.rows) * std::min(system.rows, 64));  // more than most factors need
}

void SparseRows::find_neighbours() {
  std::vector<std::vector<int>> users(spread_.size());  // per column: the constraints that use it
  for (int c = 0; c < int(ranges_.size()); ++c)
    for (int i = 0; i < ranges_[c].count; ++i) users[columns_[ranges_[c].first + i]].push_back(c);
  std::vector<int> marked(ranges_.size(), -1);  // last constraint that marked it
  for (int c = 0; c < int(ranges_.size()); ++c) {
    first_neighbour_.push_back(int(neighbours_.size()));
    neighbours_.push_back(c);
    for (int i = 0; i < ranges_[c].count; ++i) {
      const std::vector<int>& others = users[columns_[ranges_[c].first + i]];
      for (auto other = std::upper_bound(others.begin(), others.end(), c); other != others.end(); ++other)
        if (std::exchange(marked[*other], c) != c) neighbours_.push_back(*other);
    }
    std::sort(neighbours_.begin() + first_neighbour_.back(), neighbours_.end());
  }
  first_neighbour_.push_back(int(neighbours_.size()));
  products_.setZero(Eigen::Index(left_.size()), Eigen::Index(left_.size()));
}

void SparseRows::clear(int r) { std::fill_n(row(r), columns(r).size(), 0.0); }

void SparseRows::measure(const System& system, const Rows& F, int r) {
  add_to(spread_.data(), 1, r);
  solve_transposed(system, F, columns(r), spread_.data());
  double* numbers = row(r);
  for (const int u : columns(r)) *numbers++ = std::exchange(spread_[u], 0);
}

double SparseRows::dot(int r, const double* x) const {
  const double* numbers = numbers_.data() + first_[r];
  double sum = 0;
  for (const int u : columns(r)) sum += *numbers++ * x[u];
  return sum;
}

double SparseRows::dot(const Rows& L, int r, const double* x) const {
  const std::span<const int> at = columns(r);
  if (at.empty()) return 0;
  const Eigen::Index first = at.front(), count = at.back() + 1 - first;
  return L.row(r).segment(first, count).dot(Eigen::Map<const Eigen::RowVectorXd>(x + first, count));
}

void SparseRows::add_to(double* x, double factor, int r) const {
  const double* numbers = numbers_.data() + first_[r];
  for (const int u : columns(r)) x[u] += factor * *numbers++;
}

void SparseRows::relate(int i, int j, double product) {
  products_(i, j) = product;
  relatives_[i * words_ + j / 64] |= std::uint64_t(1) << (j % 64);
  relatives_[j * words_ + i / 64] |= std::uint64_t(1) << (i % 64);
  ++degree_[i], ++degree_[j];
}

void SparseRows::multiply(bool ordered) {
  if (first_neighbour_.empty()) find_neighbours();
  entries_.clear();
  first_entry_.assign(1, 0);
  std::fill(relatives_.begin(), relatives_.end(), 0);
  std::fill(degree_.begin(), degree_.end(), 0);
  for (int i = 0; i < int(left_.size()); ++i) {
    add_to(spread_.data(), 1, i);
    left_[i] = dot(i, spread_.data());
    const int own = constraint_[i];
    for (int n = first_neighbour_[own]; left_[i] > 0 && n < first_neighbour_[own + 1]; ++n) {
      const Range& rows = rows_[neighbours_[n]];
      for (int j = std::max(rows.first, i + 1); j < rows.first + rows.count; ++j)
        if (const double product = dot(j, spread_.data()); product != 0) relate(i, j, product);
    }
    for (const int u : columns(i)) spread_[u] = 0;
  }
  ordered_ = ordered;
  if (!ordered) return;
  enough_ = far_enough;  // of a unit row
  for (int i = 0; i < int(left_.size()); ++i) make_claim(i);
}

namespace {

/// The greatest of n numbers and `least`.
BORELLI_INLINED_FOR_PROCESSOR
double greatest_of(const double* x, int n, double least) {
  constexpr int width = 8;
  double of_each[width];
  std::fill_n(of_each, width, least);
  int i = 0;
  for (; i + width <= n; i += width)
    for (int c = 0; c < width; ++c) of_each[c] = x[i + c] > of_each[c] ? x[i + c] : of_each[c];
  for (; i < n; ++i) of_each[0] = x[i] > of_each[0] ? x[i] : of_each[0];
  return *std::max_element(of_each, of_each + width);
}

}  // namespace

void SparseRows::make_claim(int row) {
  // (A unit row's remainder is 1 at most, so the degree dominates.)
  claim_[row] = left_[row] >= enough_ ? left_[row] - 2 * degree_[row] : no_claim;
  blocks_[row / Block::rows].known = false;
}

double SparseRows::greatest_claim() {
  double greatest = no_claim;
  for (Block& block : blocks_) {
    if (!block.known) {
      const int first = int(&block - blocks_.data()) * Block::rows;
      block.claim =
          greatest_of(claim_.data() + first, std::min(Block::rows, int(left_.size()) - first), no_claim);
      block.known = true;
    }
    greatest = std::max(greatest, block.claim);
  }
  return greatest;
}

int SparseRows::next() {
  double claim = greatest_claim();
  if (claim == no_claim) {  // remainders only fall, so enough_ is renewed only when no candidate is left
    const double most = greatest_of(left_.data(), int(left_.size()), gone);
    if (most == gone) return -1;
    enough_ = most > 0 ? far_enough * most : most;
    for (int row = 0; row < int(left_.size()); ++row) make_claim(row);
    claim = greatest_claim();
  }
  const double left = claim + 2 * std::ceil(-claim / 2);  // (see make_claim)
  const double as_good = left > 0 ? claim - 1e-6 * left : claim;
  const auto block =
      std::find_if(blocks_.begin(), blocks_.end(), [=](const Block& one) { return one.claim >= as_good; });
  const auto first = claim_.begin() + (block - blocks_.begin()) * Block::rows;
  return int(std::find_if(first, claim_.end(), [=](double one) { return one >= as_good; }) - claim_.begin());
}

void SparseRows::eliminate(int row) {
  const double pivot = std::sqrt(left_[row]);
  left_[row] = gone;
  if (ordered_) make_claim(row);
  entries_.push_back({row, pivot});
  const std::size_t first = entries_.size();
  const std::uint64_t* const own = relatives_.data() + row * words_;
  int first_word = words_, last_word = -1;
  for (int w = 0; w < words_; ++w) {
    if (own[w] == 0) continue;
    first_word = std::min(first_word, w);
    last_word = w;
    for (std::uint64_t set = own[w]; set; set &= set - 1) {
      const int i = w * 64 + std::countr_zero(set);
      entries_.push_back({i, products_(std::min(row, i), std::max(row, i)) / pivot});
      relatives_[i * words_ + row / 64] &= ~(std::uint64_t(1) << (row % 64));
      --degree_[i];
    }
  }
  for (std::size_t a = first; a < entries_.size(); ++a) {
    const auto [i, c] = entries_[a];
    left_[i] -= c * c;
    double* const products = products_.row(i).data();
    std::uint64_t* const of_i = relatives_.data() + i * words_;
    of_i[i / 64] |= std::uint64_t(1) << (i % 64);  // (temporarily, because `own` contains it too)
    for (int w = first_word; w <= last_word; ++w)
      for (std::uint64_t fresh = own[w] & ~of_i[w]; fresh; fresh &= fresh - 1) {
        const int j = w * 64 + std::countr_zero(fresh);
        ++degree_[i];
        if (j > i) products[j] = 0;  // a new product begins at zero
      }
    for (int w = first_word; w <= last_word; ++w) of_i[w] |= own[w];
    of_i[i / 64] &= ~(std::uint64_t(1) << (i % 64));
    if (ordered_) make_claim(i);
    for (std::size_t b = a + 1; b < entries_.size(); ++b) products[entries_[b].row] -= c * entries_[b].value;
  }
  first_entry_.push_back(int(entries_.size()));
}

void SparseRows::solve_lower(double* b) const {
  for (std::size_t k = 0; k + 1 < first_entry_.size(); ++k) {
    const auto entries = column(int(k));
    const double x = b[entries[0].row] /= entries[0].value;
    for (const Entry& e : entries.subspan(1)) b[e.row] -= e.value * x;
  }
}

void SparseRows::solve_upper(double* b) const {
  for (int k = int(first_entry_.size()) - 2; k >= 0; --k) {
    const auto entries = column(k);
    double sum = b[entries[0].row];
    for (const Entry& e : entries.subspan(1)) sum -= e.value * b[e.row];
    b[entries[0].row] = sum / entries[0].value;
  }
}

}  // namespace borelli
