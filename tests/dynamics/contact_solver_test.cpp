// Contact impulses. References: all sets of active contacts (without friction), Gauss-Seidel sweeps to
// convergence (with friction), and the contact laws (dependent contacts).
#include "dynamics/contacts/contact_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "each_width.hpp"
namespace borelli::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

ContactProblem problem(const MatrixXd& G, const VectorXd& free, double friction) {
  ContactProblem out;
  out.count = int(free.size()) / 3;
  out.G = G;
  out.free = free;
  out.target = VectorXd::Zero(out.count);
  out.friction.assign(out.count, friction);
  return out;
}

/// Draws contact problems: the response of contacts on a system with `freedoms` velocities, and their
/// velocities without impulses.
struct Draw {
  std::mt19937 generator;
  std::normal_distribution<double> normal{};
  MatrixXd matrix(int rows, int columns) {
    return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
  }
  ContactProblem contacts(int count, int freedoms, double friction) {
    const MatrixXd J = matrix(3 * count, freedoms);
    // contact velocities come from a system velocity, or dependent contacts would contradict each other
    VectorXd v = matrix(freedoms, 1);
    for (int i = 0; i < count; ++i) v -= 0.3 * J.row(3 * i).transpose();  // most of them close
    return problem(J * J.transpose(), J * v, friction);
  }
};

/// Expects Signorini's and Coulomb's laws within `tolerance`, relative to velocities and impulses.
void expect_laws(const ContactProblem& c, const VectorXd& p, double tolerance) {
  const int n = 3 * c.count;
  const VectorXd u = c.free.head(n) + c.G.topLeftCorner(n, n) * p;
  const double scale = c.free.head(n).cwiseAbs().maxCoeff(), most = std::max(p.cwiseAbs().maxCoeff(), 1e-300);
  for (int i = 0; i < c.count; ++i) {
    const double normal = p[3 * i], speed = u[3 * i] - c.target[i];
    EXPECT_GE(normal, 0) << i;
    EXPECT_GE(speed, -tolerance * scale) << i;
    EXPECT_LT(std::min(normal / most, speed / scale), tolerance) << i;
    const Vector2d t = p.segment<2>(3 * i + 1), slip = u.segment<2>(3 * i + 1);
    const double limit = c.friction[i] * normal;
    EXPECT_LE(t.norm(), limit + tolerance * most) << i;
    if (slip.norm() < 1e3 * tolerance * scale) continue;  // it sticks or nearly so
    EXPECT_NEAR(t.norm(), limit, 1e-3 * most) << i;
    EXPECT_LT((t * slip.norm() + limit * slip).norm(), 1e-3 * most * slip.norm()) << i;
  }
}

class ContactSolverInRegisters : public EachWidth {};
INSTANTIATE_TEST_SUITE_P(OfEachWidth, ContactSolverInRegisters, ::testing::ValuesIn(all_widths()));

TEST_P(ContactSolverInRegisters, FindsTheUniqueSetOfActiveContacts) {
  Draw draw{std::mt19937(3)};
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 7;
    ContactProblem c = draw.contacts(n, 30, 0);
    for (int i = 0; i < n; ++i)
      for (int k = 1; k < 3; ++k) {
        c.G.row(3 * i + k).setZero();
        c.G.col(3 * i + k).setZero();
        c.free[3 * i + k] = 0;
      }
    // every set of pressing contacts: with a definite response, exactly one keeps the law
    VectorXd expected;
    int found = 0;
    for (int choice = 0; choice < 1 << n; ++choice) {
      std::vector<int> rows;
      for (int i = 0; i < n; ++i)
        if (choice >> i & 1) rows.push_back(3 * i);
      VectorXd p = VectorXd::Zero(3 * n);
      if (!rows.empty()) p(rows) = -MatrixXd(c.G)(rows, rows).llt().solve(c.free(rows));
      const VectorXd u = c.free + c.G * p;
      bool holds = p.minCoeff() >= 0;
      for (int i = 0; i < n; ++i) holds = holds && u[3 * i] > -1e-12;
      if (!holds) continue;
      ++found;
      expected = p;
    }
    ASSERT_EQ(found, 1);
    ContactSolver solver;
    VectorXd p = VectorXd::Zero(3 * n);
    EXPECT_LT(solver.solve(c, c.free.cwiseAbs().maxCoeff(), p), ContactSolver::settled);
    EXPECT_LT((p - expected).norm(), 1e-6 * expected.norm()) << trial;
  }
}

TEST_P(ContactSolverInRegisters, AgreesWithConvergedGaussSeidelSweeps) {
  Draw draw{std::mt19937(5)};
  int settled = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 6;
    const double friction = 0.2 + 0.02 * trial;
    const ContactProblem c = draw.contacts(n, 40, friction);
    VectorXd swept = VectorXd::Zero(3 * n);
    double moved = 1;
    for (int pass = 0; pass < 20000 && moved > 1e-14; ++pass) {
      moved = 0;
      for (int i = 0; i < n; ++i) {
        const VectorXd before = swept;
        const auto speed = [&](int r) { return c.free[r] + c.G.row(r).dot(swept); };
        swept[3 * i] = std::max(0., swept[3 * i] - speed(3 * i) / c.G(3 * i, 3 * i));
        const double across = c.G(3 * i + 1, 3 * i + 1) + c.G(3 * i + 2, 3 * i + 2);
        Vector2d t = swept.segment<2>(3 * i + 1) - Vector2d(speed(3 * i + 1), speed(3 * i + 2)) / across;
        const double limit = friction * swept[3 * i];
        if (t.norm() > limit) t *= limit / t.norm();
        swept.segment<2>(3 * i + 1) = t;
        moved = std::max(moved, (swept - before).cwiseAbs().maxCoeff());
      }
    }
    ContactSolver solver;
    VectorXd p = VectorXd::Zero(3 * n);
    const double scale = c.free.cwiseAbs().maxCoeff();
    EXPECT_LT(solver.solve(c, scale, p), ContactSolver::nearly);
    expect_laws(c, p, 1e-5);
    if (moved > 1e-14) continue;
    ++settled;
    EXPECT_LT((c.G * (p - swept)).cwiseAbs().maxCoeff(), 1e-5 * scale) << trial;
    // started at its own solution, it takes no steps
    const long solves = solver.solves();
    solver.solve(c, scale, p);
    EXPECT_LE(solver.solves(), solves + 1);
  }
  EXPECT_GT(settled, 40);
}

TEST_P(ContactSolverInRegisters, KeepsTheLawsForDependentContacts) {
  Draw draw{std::mt19937(7)};
  for (int trial = 0; trial < 50; ++trial) {
    const ContactProblem c = draw.contacts(12, 14, 0.1 + 0.02 * trial);  // 36 rows of rank 14
    ContactSolver solver;
    VectorXd p = VectorXd::Zero(36);
    EXPECT_LT(solver.solve(c, c.free.cwiseAbs().maxCoeff(), p), ContactSolver::nearly) << trial;
    expect_laws(c, p, 1e-5);
  }
}

// Contacts that can slide in one direction only.
TEST_P(ContactSolverInRegisters, KeepsTheLawsInAPlane) {
  Draw draw{std::mt19937(9)};
  for (int trial = 0; trial < 50; ++trial) {
    const int count = 8;
    MatrixXd J = draw.matrix(3 * count, 12);  // 16 rows that are not empty
    for (int i = 0; i < count; ++i) J.row(3 * i + 1 + (i + trial) % 2).setZero();
    VectorXd v = draw.matrix(12, 1);
    for (int i = 0; i < count; ++i) v -= 0.3 * J.row(3 * i).transpose();
    const ContactProblem c = problem(J * J.transpose(), J * v, 0.1 + 0.02 * trial);
    ContactSolver solver;
    VectorXd p = VectorXd::Zero(3 * count);
    EXPECT_LT(solver.solve(c, c.free.cwiseAbs().maxCoeff(), p), ContactSolver::nearly) << trial;
    expect_laws(c, p, 1e-5);
    for (int i = 0; i < count; ++i) EXPECT_EQ(p[3 * i + 1 + (i + trial) % 2], 0) << i;
  }
}

// One solver for many problems of different sizes.
TEST_P(ContactSolverInRegisters, SolvesEachProblemIndependently) {
  Draw draw{std::mt19937(13)};
  ContactSolver solver;
  for (const int count : {24, 1, 9, 2, 3, 22, 1}) {
    const ContactProblem alone = draw.contacts(count, 60, 0.4);
    ContactProblem roomy = alone;
    roomy.G = MatrixXd::Constant(3 * count + 5, 3 * count + 7, NAN);
    roomy.G.topLeftCorner(3 * count, 3 * count) = alone.G;
    const double scale = alone.free.cwiseAbs().maxCoeff();
    VectorXd p = VectorXd::Zero(3 * count + 4), expected = VectorXd::Zero(3 * count);
    EXPECT_LT(solver.solve(roomy, scale, p), ContactSolver::nearly) << count;
    ContactSolver fresh;
    fresh.solve(alone, scale, expected);
    EXPECT_EQ(p.head(3 * count), expected) << count;
    expect_laws(alone, p.head(3 * count), 1e-5);
    ContactProblem apart = alone;
    for (int i = 0; i < count; ++i) apart.free[3 * i] = 1;
    p.setZero();
    EXPECT_EQ(solver.solve(apart, scale, p), 0) << count;
    EXPECT_EQ(p.cwiseAbs().maxCoeff(), 0) << count;
    EXPECT_LT(solver.worst(), count);
  }
}

// Jammed bodies with friction hold each other by arbitrarily large impulses, and their masses differ as those
// of hands and trunks do. (Newton's method alone fails for one in eleven.)
TEST_P(ContactSolverInRegisters, ConvergesForJammedContacts) {
  Draw draw{std::mt19937(11)};
  std::uniform_real_distribution<double> exponent(-1.5, 1.5);
  ContactSolver solver;
  for (int freedoms : {6, 18, 40})
    for (int trial = 0; trial < 60; ++trial) {
      const int count = freedoms / 2 + 3;
      const MatrixXd J = draw.matrix(3 * count, freedoms);
      VectorXd lightness(freedoms), v = draw.matrix(freedoms, 1);
      for (double& x : lightness) x = std::pow(10, exponent(draw.generator));
      for (int i = 0; i < count; ++i) v -= 0.3 * J.row(3 * i).transpose();
      const ContactProblem c = problem(J * lightness.asDiagonal() * J.transpose(), J * v, 1);
      VectorXd p = VectorXd::Zero(3 * count);
      EXPECT_LE(solver.solve(c, c.free.cwiseAbs().maxCoeff(), p), ContactSolver::nearly)
          << freedoms << " " << trial;
      expect_laws(c, p, 1e-5);
    }
}

}  // namespace
}  // namespace borelli::test
