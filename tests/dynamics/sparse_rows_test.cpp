// The factor of the rows' Gram matrix, with its fill-in, against a dense Cholesky of the same rows.
#include "dynamics/equations/sparse_rows.hpp"

#include <Eigen/Cholesky>
#include <numbers>
#include <numeric>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/equations/equations.hpp"
#include "scenes.hpp"

namespace borelli::test {
namespace {

/// Row r of L F^-1, with F the mass matrix's factor, scaled to length 1.
void take_unit_row(SparseRows& rows, int r, const System& system, const Workspace& w) {
  const std::span<const int> columns = rows.columns(r);
  for (std::size_t i = 0; i < columns.size(); ++i) rows.row(r)[i] = w.rows.L(r, columns[i]);
  rows.measure(system, w.factor, r);
  Eigen::Map<Eigen::VectorXd>(rows.row(r), Eigen::Index(columns.size())).normalize();
}

/// Eliminates the rows of a scene's constraints; `order` must list all rows that are not zero.
void expect_factor(const System& system, const State& state, std::vector<int> order) {
  Workspace w(system);
  ASSERT_FALSE(update_terms(system, system.parameters, state.t, state.q.data(), state.v.data(), w));
  SparseRows rows(system);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(order.size(), system.nv);
  for (int r = 0; r < system.rows; ++r) {
    rows.clear(r);
    const auto at = std::find(order.begin(), order.end(), r);
    if (at == order.end()) continue;
    take_unit_row(rows, r, system, w);
    Eigen::VectorXd whole = w.rows.L.row(r).head(system.nv);  // including entries outside its columns
    solve_transposed(system, w.factor, whole.data());
    dense.row(at - order.begin()) = whole.normalized();
  }
  const Eigen::MatrixXd gram = dense * dense.transpose();
  const Eigen::MatrixXd R = gram.llt().matrixL();
  const auto place = [&](int r) { return std::find(order.begin(), order.end(), r) - order.begin(); };
  Eigen::MatrixXd left = gram;
  rows.multiply(true);
  for (std::size_t k = 0; k < order.size(); ++k) {
    // the next row is independent enough and changes the fewest other rows among such rows
    const int next = rows.next();
    ASSERT_GE(next, 0);
    const Eigen::VectorXd square = left.diagonal();
    EXPECT_NEAR(rows.left(next), square[place(next)], 1e-10);
    EXPECT_GE(rows.left(next), 0.99e-6 * square.maxCoeff());
    const auto changes = [&](Eigen::Index r) { return (left.row(r).array().abs() > 1e-14).count(); };
    for (Eigen::Index r = 0; r < square.size(); ++r)
      if (square[r] > 1.01e-6) {
        EXPECT_LE(changes(place(next)), changes(r)) << r;
      }
    EXPECT_NEAR(std::sqrt(rows.left(order[k])), R(k, k), 1e-10 * R(k, k));
    rows.eliminate(order[k]);
    EXPECT_EQ(rows.left(order[k]), SparseRows::gone);
    Eigen::VectorXd column = Eigen::VectorXd::Zero(order.size());
    for (const SparseRows::Entry& e : rows.column(int(k))) column[place(e.row)] = e.value;
    EXPECT_LT((column - R.col(k)).norm(), 1e-10 * R.norm()) << "column " << k;
    left -= R.col(k) * R.col(k).transpose();
    left.row(k).setZero();
    left.col(k).setZero();
  }
  // b by rows; rows outside the order stay zero
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(order.size(), -1, 2);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(system.rows);
  for (std::size_t k = 0; k < order.size(); ++k) x[order[k]] = b[k];
  rows.solve_lower(x.data());
  rows.solve_upper(x.data());
  const Eigen::VectorXd expected = gram.llt().solve(b);
  for (std::size_t k = 0; k < order.size(); ++k)
    EXPECT_NEAR(x[order[k]], expected[k], 1e-9 * expected.norm());
}

TEST(SparseRows, FactorLoopsInAnyOrder) {
  const System system = compiled(sample("four_bar_40.toml"));
  State state = system.initial;
  Workspace w(system);
  need(assemble(system, system.parameters, state, w));
  std::vector<int> order;
  for (int r = 0; r < system.rows; ++r)
    if (w.rows.L.row(r).head(system.nv).norm() > 1e-9) order.push_back(r);
  ASSERT_EQ(order.size(), 80u);
  expect_factor(system, state, order);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  expect_factor(system, state, order);
}

// Windows of bars: upright, leaning and nearly in line, where the two rows of each window are nearly
// dependent.
TEST(SparseRows, HaveLittleFillInInTheirOrder) {
  const System system = compiled(sample("four_bar_40.toml"));
  for (const double angle : {90., 120., 45., 10., 1.}) {
    State state = system.initial;
    for (const CoordinateInfo& info : system.coordinates)
      state.q[info.q_index] = (info.name.starts_with("crank") ? 1 : -1) * angle * std::numbers::pi / 180;
    Workspace w(system);
    ASSERT_FALSE(update_terms(system, system.parameters, 0, state.q.data(), state.v.data(), w));
    SparseRows rows(system);
    int present = 0;
    for (int r = 0; r < system.rows; ++r) {
      rows.clear(r);
      if (w.rows.L.row(r).head(system.nv).norm() < 1e-9) continue;
      ++present;
      take_unit_row(rows, r, system, w);
    }
    EXPECT_EQ(present, 80);
    rows.multiply(true);
    std::size_t entries = 0;
    for (int k = 0; k < present; ++k) {
      rows.eliminate(rows.next());
      entries += rows.column(k).size();
    }
    EXPECT_LE(entries, 5u * 80) << angle;  // 3.5 a row for a chain of pairs; a full factor has 3240
  }
}

TEST(SparseRows, FactorRowsOfBranchesAndCoordinates) {
  Scene scene = chain(6, true, 0.5);
  scene.constraints = {{"end", PointOnPoint{{"l5", {0, 0, -1}}, {"world", {0, 0, -2}}}},
                       {"far", Distance{{"l1", {0, 0, -1}}, {"l4", {0, 0, -1}}, constant(1)}},
                       {"tie", CoordinateCoupling{{{"h0"}, {"h3"}}, {1, -2}, constant(0)}}};
  const System system = compiled(scene);
  std::vector<int> order(system.rows);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 dice(5);
  for (int trial = 0; trial < 5; ++trial) {
    std::shuffle(order.begin(), order.end(), dice);
    expect_factor(system, Random(trial).state(system), order);
  }
}

}  // namespace
}  // namespace borelli::test
