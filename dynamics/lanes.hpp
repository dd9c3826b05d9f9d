// Doubles side by side: what the engine computes on them it computes for as many states (eight, Lanes) or
// bodies (four, Quad) at once. They are vectors of GCC's, so that one source serves registers of two, four
// and eight doubles: whoever computes on them for speed is compiled for each (processor.hpp).
#pragma once

#include <algorithm>

#include "dynamics/scalar.hpp"

namespace borelli {

/// N numbers in a vector, aligned like what Eigen and malloc hand out.
template <int N>
struct LaneVectors;
template <>
struct LaneVectors<8> {
  typedef double Numbers __attribute__((vector_size(64), aligned(16)));
  typedef long long Words __attribute__((vector_size(64), aligned(16)));
};
template <>
struct LaneVectors<4> {
  typedef double Numbers __attribute__((vector_size(32), aligned(16)));
  typedef long long Words __attribute__((vector_size(32), aligned(16)));
};

/// For which of N lanes a condition holds.
template <int N>
class LaneMask {
 public:
  using Vector = typename LaneVectors<N>::Words;  ///< -1: it holds; 0: not

  explicit LaneMask(const Vector& holds) : holds_(holds) {}
  LaneMask(const LaneMask& other) : holds_(other.holds_) {}
  LaneMask& operator=(const LaneMask&) = delete;

  const Vector& vector() const { return holds_; }
  bool operator[](int lane) const { return holds_[lane] != 0; }
  bool all() const { return halved<true>(); }
  bool any() const { return halved<false>(); }

 private:
  /// Whether every (else any) lane holds: the lower half by the upper until one is left, in the fewest
  /// instructions.
  template <bool every>
  bool halved() const {
    typedef long long Four __attribute__((vector_size(32), aligned(16)));
    typedef long long Two __attribute__((vector_size(16)));
    Four four;
    if constexpr (N == 8) {
      const Four low = __builtin_shufflevector(holds_, holds_, 0, 1, 2, 3);
      const Four high = __builtin_shufflevector(holds_, holds_, 4, 5, 6, 7);
      four = every ? low & high : low | high;
    } else {
      four = holds_;
    }
    const Two low = __builtin_shufflevector(four, four, 0, 1),
              high = __builtin_shufflevector(four, four, 2, 3);
    const Two two = every ? low & high : low | high;
    return (every ? two[0] & two[1] : two[0] | two[1]) != 0;
  }

  Vector holds_;
};

template <int N>
bool everywhere(const LaneMask<N>& condition) {
  return condition.all();
}

template <int N>
class LanesOf {
 public:
  static constexpr int count = N;
  using Mask = LaneMask<N>;
  using Vector = typename LaneVectors<N>::Numbers;

  LanesOf() {}
  LanesOf(double each) {  // NOLINT: a constant is the same in all lanes, in one instruction if it is so said
    if constexpr (N == 8)
      x_ = Vector{each, each, each, each, each, each, each, each};
    else
      x_ = Vector{each, each, each, each};
  }
  explicit LanesOf(const Vector& x) : x_(x) {}
  // not trivial, so that it is passed in memory whatever processor the caller is compiled for
  LanesOf(const LanesOf& other) : x_(other.x_) {}
  LanesOf& operator=(const LanesOf& other) {
    x_ = other.x_;
    return *this;
  }

  /// N numbers in memory.
  static LanesOf load(const double* from) {
    LanesOf out;
    __builtin_memcpy(&out.x_, from, sizeof out.x_);
    return out;
  }
  void store(double* to) const { __builtin_memcpy(to, &x_, sizeof x_); }

  const Vector& vector() const { return x_; }
  double operator[](int lane) const { return x_[lane]; }
  void set(int lane, double x) { x_[lane] = x; }

  LanesOf& operator+=(const LanesOf& b) { return x_ += b.x_, *this; }
  LanesOf& operator-=(const LanesOf& b) { return x_ -= b.x_, *this; }
  LanesOf& operator*=(const LanesOf& b) { return x_ *= b.x_, *this; }
  LanesOf& operator/=(const LanesOf& b) { return x_ /= b.x_, *this; }
  LanesOf operator-() const { return LanesOf(-x_); }
  friend LanesOf operator+(const LanesOf& a, const LanesOf& b) { return LanesOf(a.x_ + b.x_); }
  friend LanesOf operator-(const LanesOf& a, const LanesOf& b) { return LanesOf(a.x_ - b.x_); }
  friend LanesOf operator*(const LanesOf& a, const LanesOf& b) { return LanesOf(a.x_ * b.x_); }
  friend LanesOf operator/(const LanesOf& a, const LanesOf& b) { return LanesOf(a.x_ / b.x_); }
  friend LanesOf operator+(const LanesOf& a, double b) { return LanesOf(a.x_ + b); }
  friend LanesOf operator-(const LanesOf& a, double b) { return LanesOf(a.x_ - b); }
  friend LanesOf operator*(const LanesOf& a, double b) { return LanesOf(a.x_ * b); }
  friend LanesOf operator/(const LanesOf& a, double b) { return LanesOf(a.x_ / b); }
  friend LanesOf operator+(double a, const LanesOf& b) { return LanesOf(a + b.x_); }
  friend LanesOf operator-(double a, const LanesOf& b) { return LanesOf(a - b.x_); }
  friend LanesOf operator*(double a, const LanesOf& b) { return LanesOf(a * b.x_); }
  friend LanesOf operator/(double a, const LanesOf& b) { return LanesOf(a / b.x_); }

  friend Mask operator<(const LanesOf& a, const LanesOf& b) { return Mask(a.x_ < b.x_); }
  friend Mask operator>(const LanesOf& a, const LanesOf& b) { return Mask(a.x_ > b.x_); }
  friend Mask operator<=(const LanesOf& a, const LanesOf& b) { return Mask(a.x_ <= b.x_); }
  friend Mask operator>=(const LanesOf& a, const LanesOf& b) { return Mask(a.x_ >= b.x_); }
  friend Mask operator==(const LanesOf& a, const LanesOf& b) { return Mask(a.x_ == b.x_); }

 private:
  Vector x_;
};

using Lanes = LanesOf<8>;
using Quad = LanesOf<4>;

template <int N>
constexpr bool is_lanes<LanesOf<N>> = true;

template <int N>
double largest(const LanesOf<N>& x) {
  double out = x[0];
  for (int lane = 1; lane < N; ++lane) out = std::max(out, x[lane]);
  return out;
}

template <int N>
LanesOf<N> choose(const LaneMask<N>& condition, const LanesOf<N>& yes, const LanesOf<N>& no) {
  return LanesOf<N>(condition.vector() ? yes.vector() : no.vector());
}
template <int N, class M>
M choose(const LaneMask<N>& condition, const M& yes, const M& no) {  // of Eigen's matrices of lanes
  M out;
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out.data()[i] = choose(condition, yes.data()[i], no.data()[i]);
  return out;
}

/// As scalar.hpp's, lane by lane; what no lane asks for is not evaluated.
template <int N, class Yes, class No>
auto either(const LaneMask<N>& condition, Yes&& yes, No&& no) {
  using Out = decltype(yes());
  if (condition.all()) return Out(yes());
  if (!condition.any()) return Out(no());
  return choose(condition, Out(yes()), Out(no()));
}

/// f of each lane by itself.
template <int N, class F>
LanesOf<N> lane_by_lane(const LanesOf<N>& x, F&& f) {
  typename LanesOf<N>::Vector out{};
  for (int i = 0; i < N; ++i) out[i] = f(x[i]);
  return LanesOf<N>(out);
}

template <int N>
LanesOf<N> sqrt(const LanesOf<N>& x) {
  return lane_by_lane(x, [](double each) { return std::sqrt(each); });
}
template <int N>
LanesOf<N> abs(const LanesOf<N>& x) {
  return choose(x < 0, -x, x);
}
template <int N>
LanesOf<N> atan2(const LanesOf<N>& y, const LanesOf<N>& x) {
  LanesOf<N> out;
  for (int i = 0; i < N; ++i) out.set(i, std::atan2(y[i], x[i]));
  return out;
}

/// sin(x) and, a quarter of a turn on, cos(x): the nearest quarter turn is taken off in three parts, of which
/// the products are exact (Cody, Waite, Software Manual for the Elementary Functions, 1980; the parts are
/// fdlibm's), and polynomials do the rest (Moshier, Cephes, to 1 unit in the last place on an eighth turn).
template <int N>
LanesOf<N> sine(const LanesOf<N>& angle, int quarters) {
  using Vector = typename LanesOf<N>::Vector;
  constexpr double farthest = 524288;  // quarter turns have 20 bits at most
  if (!everywhere(abs(angle) < farthest))
    return lane_by_lane(angle, [&](double x) { return quarters ? std::cos(x) : std::sin(x); });
  constexpr double shift = 0x1.8p52;  // pushes what is less than one out of a number, and the rest to its end
  const Vector x = angle.vector(), shifted = x * 0.63661977236758134308 + shift, turns = shifted - shift;
  const Vector r = ((x - turns * 1.57079632673412561417e+00) - turns * 6.07710050630396597660e-11) -
                   turns * 2.02226624879595063154e-21;
  const Vector z = r * r;
  const Vector s =
      r +
      r * z *
          (((((1.58962301576546568060E-10 * z - 2.50507477628578072866E-8) * z + 2.75573136213857245213E-6) *
                 z -
             1.98412698295895385996E-4) *
                z +
            8.33333333332211858878E-3) *
               z -
           1.66666666666666307295E-1);
  const Vector c =
      (1 - 0.5 * z) +
      z * z *
          (((((-1.13585365213876817300E-11 * z + 2.08757008419747316778E-9) * z - 2.75573141792967388112E-7) *
                 z +
             2.48015872888517045348E-5) *
                z -
            1.38888888888730564116E-3) *
               z +
           4.16666666666665929218E-2);
  typename LaneMask<N>::Vector quarter;
  static_assert(sizeof quarter == sizeof shifted);
  __builtin_memcpy(&quarter, &shifted, sizeof quarter);
  quarter += quarters;
  const Vector size = (quarter & 1) != 0 ? c : s;
  return LanesOf<N>((quarter & 2) != 0 ? -size : size);
}
template <int N>
LanesOf<N> sin(const LanesOf<N>& x) {
  return sine(x, 0);
}
template <int N>
LanesOf<N> cos(const LanesOf<N>& x) {
  return sine(x, 1);
}

}  // namespace borelli

template <int N>
struct Eigen::NumTraits<borelli::LanesOf<N>> : Eigen::NumTraits<double> {
  using Real = borelli::LanesOf<N>;
  using NonInteger = borelli::LanesOf<N>;
  using Nested = borelli::LanesOf<N>;
  using Literal = double;
  enum { RequireInitialization = 1 };
};
template <int N, class Operation>
struct Eigen::ScalarBinaryOpTraits<borelli::LanesOf<N>, double, Operation> {
  using ReturnType = borelli::LanesOf<N>;
};
template <int N, class Operation>
struct Eigen::ScalarBinaryOpTraits<double, borelli::LanesOf<N>, Operation> {
  using ReturnType = borelli::LanesOf<N>;
};
