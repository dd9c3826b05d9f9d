#include "dynamics/inverse/quintic_spline.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace borelli {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A piece of length h is
///   p0 + v0 s + a0 s^2 / 2 + c3 s^3 + c4 s^4 + c5 s^5,
/// where each c is a combination of the step d = p1 - p0 and the rates v and second derivatives a at its
/// ends.
struct PieceWeights {
  double d = 0;
  Eigen::RowVector2d before, after;  ///< of (v0, a0) and (v1, a1)

  PieceWeights operator*(double x) const { return {d * x, before * x, after * x}; }
  PieceWeights operator+(const PieceWeights& o) const {
    return {d + o.d, before + o.before, after + o.after};
  }
};

struct PieceCoefficients {
  PieceWeights c3, c4, c5;
  explicit PieceCoefficients(double h)
      : c3{10 / (h * h * h), {-6 / (h * h), -1.5 / h}, {-4 / (h * h), 0.5 / h}},
        c4{-15 / (h * h * h * h), {8 / (h * h * h), 1.5 / (h * h)}, {7 / (h * h * h), -1 / (h * h)}},
        c5{6 / std::pow(h, 5),
           {-3 / std::pow(h, 4), -0.5 / std::pow(h, 3)},
           {-3 / std::pow(h, 4), 0.5 / std::pow(h, 3)}} {}

  // third and fourth derivatives at the ends of the piece
  PieceWeights third_before() const { return c3 * 6; }
  PieceWeights fourth_before() const { return c4 * 24; }
  PieceWeights third_after(double h) const { return c3 * 6 + c4 * (24 * h) + c5 * (60 * h * h); }
  PieceWeights fourth_after(double h) const { return c4 * 24 + c5 * (120 * h); }
};

}  // namespace

Result<QuinticSpline> QuinticSpline::through(std::vector<double> times, MatrixXd values) {
  const std::string where = "spline through a motion";
  if (times.size() < 3) return bad_use(where, fmt::format("needs at least 3 instants, has {}", times.size()));
  if (values.rows() != Eigen::Index(times.size()))
    return bad_use(where, "the numbers of times and of rows differ");
  for (std::size_t i = 0; i < times.size(); ++i)
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
      return bad_use(where,
                     fmt::format("time {} of row {} is not after the time before it", times[i], i + 1));
  if (!values.allFinite()) return bad_use(where, "a value is not a finite number");
  QuinticSpline spline;
  spline.times_ = std::move(times);
  spline.values_ = std::move(values);
  spline.fit();
  return spline;
}

/// Third and fourth derivatives agree where pieces meet, and vanish at the ends: a block tridiagonal system
/// for (v, a) at every time, which elimination solves without pivoting between blocks.
void QuinticSpline::fit() {
  const std::size_t n = times_.size();
  const Eigen::Index columns = values_.cols();
  rates_.resize(Eigen::Index(n), columns);
  seconds_.resize(Eigen::Index(n), columns);
  std::vector<Matrix2d> after(n);  // eliminated blocks above the diagonal
  std::vector<MatrixXd> right(n);  // 2 x columns
  for (std::size_t i = 0; i < n; ++i) {
    Matrix2d below = Matrix2d::Zero(), diagonal = Matrix2d::Zero(), above = Matrix2d::Zero();
    MatrixXd side = MatrixXd::Zero(2, columns);
    // equations in the scale of one second at the local step, so that the blocks are alike
    const double unit = i + 1 < n ? times_[i + 1] - times_[i] : times_[i] - times_[i - 1];
    const Eigen::Vector2d scale{unit * unit * unit, unit * unit * unit * unit};
    if (i + 1 < n) {
      const double h = times_[i + 1] - times_[i];
      const PieceCoefficients piece(h);
      const Eigen::RowVectorXd d = values_.row(Eigen::Index(i + 1)) - values_.row(Eigen::Index(i));
      const PieceWeights weights[2] = {piece.third_before(), piece.fourth_before()};
      for (int k = 0; k < 2; ++k) {
        diagonal.row(k) += scale[k] * weights[k].before;
        above.row(k) += scale[k] * weights[k].after;
        side.row(k) -= scale[k] * weights[k].d * d;
      }
    }
    if (i > 0) {
      const double h = times_[i] - times_[i - 1];
      const PieceCoefficients piece(h);
      const Eigen::RowVectorXd d = values_.row(Eigen::Index(i)) - values_.row(Eigen::Index(i - 1));
      const PieceWeights weights[2] = {piece.third_after(h), piece.fourth_after(h)};
      for (int k = 0; k < 2; ++k) {
        below.row(k) -= scale[k] * weights[k].before;
        diagonal.row(k) -= scale[k] * weights[k].after;
        side.row(k) += scale[k] * weights[k].d * d;
      }
      diagonal -= below * after[i - 1];
      side -= below * right[i - 1];
    }
    const Matrix2d inverse = diagonal.inverse();
    after[i] = inverse * above;
    right[i] = inverse * side;
  }
  for (std::size_t i = n; i-- > 0;) {
    if (i + 1 < n) right[i] -= after[i] * right[i + 1];
    rates_.row(Eigen::Index(i)) = right[i].row(0);
    seconds_.row(Eigen::Index(i)) = right[i].row(1);
  }
}

void QuinticSpline::at(double t, VectorXd& value, VectorXd& rate, VectorXd& second) const {
  const auto next = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  const Eigen::Index i = next - times_.begin() - 1;
  const double h = times_[std::size_t(i + 1)] - times_[std::size_t(i)], s = t - times_[std::size_t(i)];
  const PieceCoefficients piece(h);
  const auto coefficient = [&](const PieceWeights& w) -> VectorXd {
    return (w.d * (values_.row(i + 1) - values_.row(i)) + w.before[0] * rates_.row(i) +
            w.before[1] * seconds_.row(i) + w.after[0] * rates_.row(i + 1) + w.after[1] * seconds_.row(i + 1))
        .transpose();
  };
  const VectorXd c3 = coefficient(piece.c3), c4 = coefficient(piece.c4), c5 = coefficient(piece.c5);
  const VectorXd p = values_.row(i).transpose(), v = rates_.row(i).transpose(),
                 a = seconds_.row(i).transpose();
  value = p + s * (v + s * (a / 2 + s * (c3 + s * (c4 + s * c5))));
  rate = v + s * (a + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)));
  second = a + s * (6 * c3 + s * (12 * c4 + s * 20 * c5));
}

}  // namespace borelli
