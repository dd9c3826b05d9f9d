// SIMD numbers: doubles side by side. The engine evaluated on them handles several states (eight, Lanes) or
// bodies (four, Quad) at once. They are GCC vectors no wider than a register, since GCC assembles wider ones
// in memory. So fast code is compiled once for each register width (processor.hpp).
#pragma once

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// GCC vectors of `width` numbers in a register. Aligned to 16 bytes, as memory from Eigen and malloc is.
template <int width>
struct Register;
template <>
struct Register<8> {
  typedef double Numbers __attribute__((vector_size(64), aligned(16)));
  typedef long long Words __attribute__((vector_size(64), aligned(16)));
};
template <>
struct Register<4> {
  typedef double Numbers __attribute__((vector_size(32), aligned(16)));
  typedef long long Words __attribute__((vector_size(32), aligned(16)));
};
template <>
struct Register<2> {
  typedef double Numbers __attribute__((vector_size(16)));
  typedef long long Words __attribute__((vector_size(16)));
};

/// A condition for each of N lanes.
template <int N, int width>
class LaneMask {
 public:
  using Half = LaneMask<N / 2, width>;

  LaneMask(const Half& low, const Half& high) : low_(low), high_(high) {}
  LaneMask(const LaneMask& other) : low_(other.low_), high_(other.high_) {}
  LaneMask& operator=(const LaneMask&) = delete;

  const Half& low() const { return low_; }
  const Half& high() const { return high_; }
  bool operator[](int lane) const { return lane < N / 2 ? low_[lane] : high_[lane - N / 2]; }
  bool all() const { return (low_ & high_).all(); }
  bool any() const { return (low_ | high_).any(); }
  friend LaneMask operator&(const LaneMask& a, const LaneMask& b) {
    return {a.low_ & b.low_, a.high_ & b.high_};
  }
  friend LaneMask operator|(const LaneMask& a, const LaneMask& b) {
    return {a.low_ | b.low_, a.high_ | b.high_};
  }

 private:
  Half low_, high_;
};
template <int N>
class LaneMask<N, N> {
 public:
  using Vector = typename Register<N>::Words;  ///< -1: true; 0: false

  explicit LaneMask(const Vector& holds) : holds_(holds) {}
  LaneMask(const LaneMask& other) : holds_(other.holds_) {}
  LaneMask& operator=(const LaneMask&) = delete;

  const Vector& vector() const { return holds_; }
  bool operator[](int lane) const { return holds_[lane] != 0; }
  bool all() const { return reduced<true>(); }
  bool any() const { return reduced<false>(); }
  // (For speed, call all() on one comparison after the other. GCC 12 evaluates comparisons joined by & number
  // by number in registers of eight.)
  friend LaneMask operator&(const LaneMask& a, const LaneMask& b) { return LaneMask(a.holds_ & b.holds_); }
  friend LaneMask operator|(const LaneMask& a, const LaneMask& b) { return LaneMask(a.holds_ | b.holds_); }

 private:
  /// Whether every lane is true (`every`), or any. Few instructions: eight lanes become the bytes of one
  /// word; four lanes combine their lower and upper halves.
  template <bool every>
  bool reduced() const {
    using Two = typename Register<2>::Words;
    typedef signed char Bytes __attribute__((vector_size(8)));
    if constexpr (N == 8) {
      const Bytes bytes = __builtin_convertvector(holds_, Bytes);
      long long word;
      __builtin_memcpy(&word, &bytes, sizeof word);
      return every ? word == -1 : word != 0;
    } else if constexpr (N == 4) {
      const Two low = __builtin_shufflevector(holds_, holds_, 0, 1),
                high = __builtin_shufflevector(holds_, holds_, 2, 3);
      const Two two = every ? low & high : low | high;
      return (every ? two[0] & two[1] : two[0] | two[1]) != 0;
    } else {
      return (every ? holds_[0] & holds_[1] : holds_[0] | holds_[1]) != 0;
    }
  }

  Vector holds_;
};

template <int N, int width>
bool everywhere(const LaneMask<N, width>& condition) {
  return condition.all();
}

/// N numbers in registers of `width`.
template <int N, int width>
class LanesOf {
 public:
  static constexpr int count = N;
  using Mask = LaneMask<N, width>;
  using Half = LanesOf<N / 2, width>;

  LanesOf() {}
  LanesOf(double each) : low_(each), high_(each) {}  // NOLINT: a constant is the same in all lanes
  LanesOf(const Half& low, const Half& high) : low_(low), high_(high) {}
  LanesOf(const LanesOf& other) : low_(other.low_), high_(other.high_) {}
  LanesOf& operator=(const LanesOf& other) {
    low_ = other.low_, high_ = other.high_;
    return *this;
  }

  static LanesOf load(const double* from) { return {Half::load(from), Half::load(from + N / 2)}; }
  void store(double* to) const { low_.store(to), high_.store(to + N / 2); }

  const Half& low() const { return low_; }
  const Half& high() const { return high_; }
  double operator[](int lane) const { return lane < N / 2 ? low_[lane] : high_[lane - N / 2]; }
  void set(int lane, double x) { lane < N / 2 ? low_.set(lane, x) : high_.set(lane - N / 2, x); }

  LanesOf& operator+=(const LanesOf& b) { return low_ += b.low_, high_ += b.high_, *this; }
  LanesOf& operator-=(const LanesOf& b) { return low_ -= b.low_, high_ -= b.high_, *this; }
  LanesOf& operator*=(const LanesOf& b) { return low_ *= b.low_, high_ *= b.high_, *this; }
  LanesOf& operator/=(const LanesOf& b) { return low_ /= b.low_, high_ /= b.high_, *this; }
  LanesOf operator-() const { return {-low_, -high_}; }
  friend LanesOf operator+(const LanesOf& a, const LanesOf& b) {
    return {a.low_ + b.low_, a.high_ + b.high_};
  }
  friend LanesOf operator-(const LanesOf& a, const LanesOf& b) {
    return {a.low_ - b.low_, a.high_ - b.high_};
  }
  friend LanesOf operator*(const LanesOf& a, const LanesOf& b) {
    return {a.low_ * b.low_, a.high_ * b.high_};
  }
  friend LanesOf operator/(const LanesOf& a, const LanesOf& b) {
    return {a.low_ / b.low_, a.high_ / b.high_};
  }
  friend LanesOf operator+(const LanesOf& a, double b) { return {a.low_ + b, a.high_ + b}; }
  friend LanesOf operator-(const LanesOf& a, double b) { return {a.low_ - b, a.high_ - b}; }
  friend LanesOf operator*(const LanesOf& a, double b) { return {a.low_ * b, a.high_ * b}; }
  friend LanesOf operator/(const LanesOf& a, double b) { return {a.low_ / b, a.high_ / b}; }
  friend LanesOf operator+(double a, const LanesOf& b) { return {a + b.low_, a + b.high_}; }
  friend LanesOf operator-(double a, const LanesOf& b) { return {a - b.low_, a - b.high_}; }
  friend LanesOf operator*(double a, const LanesOf& b) { return {a * b.low_, a * b.high_}; }
  friend LanesOf operator/(double a, const LanesOf& b) { return {a / b.low_, a / b.high_}; }

  friend Mask operator<(const LanesOf& a, const LanesOf& b) { return {a.low_ < b.low_, a.high_ < b.high_}; }
  friend Mask operator>(const LanesOf& a, const LanesOf& b) { return {a.low_ > b.low_, a.high_ > b.high_}; }
  friend Mask operator<=(const LanesOf& a, const LanesOf& b) {
    return {a.low_ <= b.low_, a.high_ <= b.high_};
  }
  friend Mask operator>=(const LanesOf& a, const LanesOf& b) {
    return {a.low_ >= b.low_, a.high_ >= b.high_};
  }
  friend Mask operator==(const LanesOf& a, const LanesOf& b) {
    return {a.low_ == b.low_, a.high_ == b.high_};
  }

 private:
  Half low_, high_;
};
template <int N>
class LanesOf<N, N> {
 public:
  static constexpr int count = N;
  using Mask = LaneMask<N, N>;
  using Vector = typename Register<N>::Numbers;

  LanesOf() {}
  LanesOf(double each) {     // NOLINT: a constant is the same in all lanes
    if constexpr (N == 8) {  // (from braces GCC 12 inserts eight one by one)
      const Vector first{each};
      x_ = __builtin_shufflevector(first, first, 0, 0, 0, 0, 0, 0, 0, 0);
    } else if constexpr (N == 4) {
      x_ = Vector{each, each, each, each};
    } else {
      x_ = Vector{each, each};
    }
  }
  explicit LanesOf(const Vector& x) : x_(x) {}
  // Not trivial: so every caller passes it in memory, whatever processor that caller is compiled for.
  LanesOf(const LanesOf& other) : x_(other.x_) {}
  LanesOf& operator=(const LanesOf& other) {
    x_ = other.x_;
    return *this;
  }

  /// Loads N consecutive numbers from memory.
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

/// The types in which data is stored. LanesOf with other register widths have the same memory layout.
using Lanes = LanesOf<8, 4>;
using Quad = LanesOf<4, 4>;

template <int N, int width>
constexpr bool is_lanes<LanesOf<N, width>> = true;

template <int N, int width>
const LanesOf<N, width>& value_of(const LanesOf<N, width>& x) {
  return x;
}

template <int N>
LanesOf<N, N> choose(const LaneMask<N, N>& condition, const LanesOf<N, N>& yes, const LanesOf<N, N>& no) {
  return LanesOf<N, N>(condition.vector() ? yes.vector() : no.vector());
}
template <int N, int width>
LanesOf<N, width> choose(const LaneMask<N, width>& condition, const LanesOf<N, width>& yes,
                         const LanesOf<N, width>& no) {
  return {choose(condition.low(), yes.low(), no.low()), choose(condition.high(), yes.high(), no.high())};
}
template <int N, int width>
LanesOf<N, width> larger(const LanesOf<N, width>& a, const LanesOf<N, width>& b) {
  return choose(a < b, b, a);
}
template <int N, int width, class M>
M choose(const LaneMask<N, width>& condition, const M& yes, const M& no) {  // for Eigen matrices of lanes
  M out;
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out.data()[i] = choose(condition, yes.data()[i], no.data()[i]);
  return out;
}

/// `either` of scalar.hpp, lane by lane. A branch that no lane takes is not evaluated.
template <int N, int width, class Yes, class No>
auto either(const LaneMask<N, width>& condition, Yes&& yes, No&& no) {
  using Out = decltype(yes());
  if (condition.all()) return Out(yes());
  if (!condition.any()) return Out(no());
  return choose(condition, Out(yes()), Out(no()));
}

/// Applies f to each lane.
template <int N, int width, class F>
LanesOf<N, width> lane_by_lane(const LanesOf<N, width>& x, F&& f) {
  LanesOf<N, width> out = 0;
  for (int i = 0; i < N; ++i) out.set(i, f(x[i]));
  return out;
}

template <int N, int width>
LanesOf<N, width> sqrt(const LanesOf<N, width>& x) {
  return lane_by_lane(x, [](double each) { return std::sqrt(each); });
}
template <int N, int width>
LanesOf<N, width> abs(const LanesOf<N, width>& x) {
  return choose(x < 0, -x, x);
}
template <int N, int width>
LanesOf<N, width> atan2(const LanesOf<N, width>& y, const LanesOf<N, width>& x) {
  LanesOf<N, width> out = 0;
  for (int i = 0; i < N; ++i) out.set(i, std::atan2(y[i], x[i]));
  return out;
}

/// sin(angle + quarters pi/2): the sine for `quarters` 0, the cosine for 1; angle in rad. The nearest
/// multiple of pi/2 is subtracted in three parts, whose products are exact (Cody, Waite, Software Manual for
/// the Elementary Functions, 1980; the parts are those of fdlibm). Polynomials evaluate the rest (Moshier,
/// Cephes, to 1 unit in the last place for |x| <= pi/4).
template <int N>
LanesOf<N, N> sine(const LanesOf<N, N>& angle, int quarters) {
  using Vector = typename LanesOf<N, N>::Vector;
  constexpr double farthest = 524288;  // the number of quarter turns has 20 bits at most
  if (!everywhere(abs(angle) < farthest))
    return lane_by_lane(angle, [&](double x) { return quarters ? std::cos(x) : std::sin(x); });
  constexpr double shift = 0x1.8p52;  // adding it rounds to an integer and puts that in the lowest bits
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
  typename LaneMask<N, N>::Vector quarter;
  static_assert(sizeof quarter == sizeof shifted);
  __builtin_memcpy(&quarter, &shifted, sizeof quarter);
  quarter += quarters;
  const Vector size = (quarter & 1) != 0 ? c : s;
  return LanesOf<N, N>((quarter & 2) != 0 ? -size : size);
}
template <int N, int width>
LanesOf<N, width> sine(const LanesOf<N, width>& angle, int quarters) {
  return {sine(angle.low(), quarters), sine(angle.high(), quarters)};
}
template <int N, int width>
LanesOf<N, width> sin(const LanesOf<N, width>& x) {
  return sine(x, 0);
}
template <int N, int width>
LanesOf<N, width> cos(const LanesOf<N, width>& x) {
  return sine(x, 1);
}

}  // namespace borelli

template <int N, int width>
struct Eigen::NumTraits<borelli::LanesOf<N, width>> : Eigen::NumTraits<double> {
  using Real = borelli::LanesOf<N, width>;
  using NonInteger = borelli::LanesOf<N, width>;
  using Nested = borelli::LanesOf<N, width>;
  using Literal = double;
  enum { RequireInitialization = 1 };
};
template <int N, int width, class Operation>
struct Eigen::ScalarBinaryOpTraits<borelli::LanesOf<N, width>, double, Operation> {
  using ReturnType = borelli::LanesOf<N, width>;
};
template <int N, int width, class Operation>
struct Eigen::ScalarBinaryOpTraits<double, borelli::LanesOf<N, width>, Operation> {
  using ReturnType = borelli::LanesOf<N, width>;
};
