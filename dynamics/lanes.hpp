// Eight doubles side by side: what the engine computes on them it computes for eight states at once. They are
// a vector of GCC's, so that one source serves registers of two, four and eight doubles: whoever computes on
// them for speed is compiled for each (processor.hpp).
#pragma once

#include "dynamics/scalar.hpp"

namespace borelli {

/// For which of eight lanes a condition holds.
class LaneMask {
 public:
  typedef long long Vector __attribute__((vector_size(64), aligned(16)));  // -1: it holds; 0: not

  explicit LaneMask(const Vector& holds) : holds_(holds) {}
  LaneMask(const LaneMask& other) : holds_(other.holds_) {}
  LaneMask& operator=(const LaneMask&) = delete;

  const Vector& vector() const { return holds_; }
  bool operator[](int lane) const { return holds_[lane] != 0; }
  bool all() const {
    long long all = -1;
    for (int i = 0; i < 8; ++i) all &= holds_[i];
    return all != 0;
  }
  bool any() const {
    long long any = 0;
    for (int i = 0; i < 8; ++i) any |= holds_[i];
    return any != 0;
  }

 private:
  Vector holds_;
};

inline bool everywhere(const LaneMask& condition) { return condition.all(); }

class Lanes {
 public:
  static constexpr int count = 8;
  // (aligned like what Eigen and malloc hand out)
  typedef double Vector __attribute__((vector_size(64), aligned(16)));

  Lanes() : x_{} {}
  Lanes(double each) : x_(each - Vector{}) {}  // NOLINT: a constant is the same in all lanes
  explicit Lanes(const Vector& x) : x_(x) {}
  // not trivial, so that it is passed in memory whatever processor the caller is compiled for
  Lanes(const Lanes& other) : x_(other.x_) {}
  Lanes& operator=(const Lanes& other) {
    x_ = other.x_;
    return *this;
  }

  /// Eight numbers in memory.
  static Lanes load(const double* from) {
    Lanes out;
    __builtin_memcpy(&out.x_, from, sizeof out.x_);
    return out;
  }
  void store(double* to) const { __builtin_memcpy(to, &x_, sizeof x_); }

  const Vector& vector() const { return x_; }
  double operator[](int lane) const { return x_[lane]; }
  void set(int lane, double x) { x_[lane] = x; }

  Lanes& operator+=(const Lanes& b) { return x_ += b.x_, *this; }
  Lanes& operator-=(const Lanes& b) { return x_ -= b.x_, *this; }
  Lanes& operator*=(const Lanes& b) { return x_ *= b.x_, *this; }
  Lanes& operator/=(const Lanes& b) { return x_ /= b.x_, *this; }
  Lanes operator-() const { return Lanes(-x_); }
  friend Lanes operator+(const Lanes& a, const Lanes& b) { return Lanes(a.x_ + b.x_); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return Lanes(a.x_ - b.x_); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return Lanes(a.x_ * b.x_); }
  friend Lanes operator/(const Lanes& a, const Lanes& b) { return Lanes(a.x_ / b.x_); }
  friend Lanes operator+(const Lanes& a, double b) { return Lanes(a.x_ + b); }
  friend Lanes operator-(const Lanes& a, double b) { return Lanes(a.x_ - b); }
  friend Lanes operator*(const Lanes& a, double b) { return Lanes(a.x_ * b); }
  friend Lanes operator/(const Lanes& a, double b) { return Lanes(a.x_ / b); }
  friend Lanes operator+(double a, const Lanes& b) { return Lanes(a + b.x_); }
  friend Lanes operator-(double a, const Lanes& b) { return Lanes(a - b.x_); }
  friend Lanes operator*(double a, const Lanes& b) { return Lanes(a * b.x_); }
  friend Lanes operator/(double a, const Lanes& b) { return Lanes(a / b.x_); }

  friend LaneMask operator<(const Lanes& a, const Lanes& b) { return LaneMask(a.x_ < b.x_); }
  friend LaneMask operator>(const Lanes& a, const Lanes& b) { return LaneMask(a.x_ > b.x_); }
  friend LaneMask operator<=(const Lanes& a, const Lanes& b) { return LaneMask(a.x_ <= b.x_); }
  friend LaneMask operator>=(const Lanes& a, const Lanes& b) { return LaneMask(a.x_ >= b.x_); }
  friend LaneMask operator==(const Lanes& a, const Lanes& b) { return LaneMask(a.x_ == b.x_); }

 private:
  Vector x_;
};

inline Lanes choose(const LaneMask& condition, const Lanes& yes, const Lanes& no) {
  return Lanes(condition.vector() ? yes.vector() : no.vector());
}
template <class M>
M choose(const LaneMask& condition, const M& yes, const M& no) {  // of Eigen's matrices of lanes
  M out;
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out.data()[i] = choose(condition, yes.data()[i], no.data()[i]);
  return out;
}

/// As scalar.hpp's, lane by lane; what no lane asks for is not evaluated.
template <class Yes, class No>
auto either(const LaneMask& condition, Yes&& yes, No&& no) {
  using Out = decltype(yes());
  if (condition.all()) return Out(yes());
  if (!condition.any()) return Out(no());
  return choose(condition, Out(yes()), Out(no()));
}

/// f of each lane by itself.
template <class F>
Lanes lane_by_lane(const Lanes& x, F&& f) {
  Lanes::Vector out{};
  for (int i = 0; i < Lanes::count; ++i) out[i] = f(x[i]);
  return Lanes(out);
}

inline Lanes sqrt(const Lanes& x) {
  return lane_by_lane(x, [](double each) { return std::sqrt(each); });
}
inline Lanes abs(const Lanes& x) { return choose(x < 0, -x, x); }
inline Lanes atan2(const Lanes& y, const Lanes& x) {
  Lanes out;
  for (int i = 0; i < Lanes::count; ++i) out.set(i, std::atan2(y[i], x[i]));
  return out;
}

/// sin(x) and, a quarter of a turn on, cos(x): the nearest quarter turn is taken off in three parts, of which
/// the products are exact (Cody, Waite, Software Manual for the Elementary Functions, 1980; the parts are
/// fdlibm's), and polynomials do the rest (Moshier, Cephes, to 1 unit in the last place on an eighth turn).
inline Lanes sine(const Lanes& angle, int quarters) {
  constexpr double farthest = 524288;  // quarter turns have 20 bits at most
  if (!everywhere(abs(angle) < farthest))
    return lane_by_lane(angle, [&](double x) { return quarters ? std::cos(x) : std::sin(x); });
  constexpr double shift = 0x1.8p52;  // pushes what is less than one out of a number, and the rest to its end
  const Lanes::Vector x = angle.vector(), shifted = x * 0.63661977236758134308 + shift,
                      turns = shifted - shift;
  const Lanes::Vector r = ((x - turns * 1.57079632673412561417e+00) - turns * 6.07710050630396597660e-11) -
                          turns * 2.02226624879595063154e-21;
  const Lanes::Vector z = r * r;
  const Lanes::Vector s =
      r +
      r * z *
          (((((1.58962301576546568060E-10 * z - 2.50507477628578072866E-8) * z + 2.75573136213857245213E-6) *
                 z -
             1.98412698295895385996E-4) *
                z +
            8.33333333332211858878E-3) *
               z -
           1.66666666666666307295E-1);
  const Lanes::Vector c =
      (1 - 0.5 * z) +
      z * z *
          (((((-1.13585365213876817300E-11 * z + 2.08757008419747316778E-9) * z - 2.75573141792967388112E-7) *
                 z +
             2.48015872888517045348E-5) *
                z -
            1.38888888888730564116E-3) *
               z +
           4.16666666666665929218E-2);
  LaneMask::Vector quarter;
  static_assert(sizeof quarter == sizeof shifted);
  __builtin_memcpy(&quarter, &shifted, sizeof quarter);
  quarter += quarters;
  const Lanes::Vector size = (quarter & 1) != 0 ? c : s;
  return Lanes((quarter & 2) != 0 ? -size : size);
}
inline Lanes sin(const Lanes& x) { return sine(x, 0); }
inline Lanes cos(const Lanes& x) { return sine(x, 1); }

}  // namespace borelli

template <>
struct Eigen::NumTraits<borelli::Lanes> : Eigen::NumTraits<double> {
  using Real = borelli::Lanes;
  using NonInteger = borelli::Lanes;
  using Nested = borelli::Lanes;
  using Literal = double;
  enum { RequireInitialization = 1 };
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<borelli::Lanes, double, Operation> {
  using ReturnType = borelli::Lanes;
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<double, borelli::Lanes, Operation> {
  using ReturnType = borelli::Lanes;
};
