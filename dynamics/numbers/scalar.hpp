// Requirements on the scalar type. The equations are written once over a type T: double, a dual number
// (dual.hpp) that carries derivatives, or a lane type of several doubles side by side (lanes.hpp).
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "error/eigen_layout.hpp"

namespace borelli {

/// A row-major matrix.
template <class T>
using RowsOf = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Alignment of structures in large arrays: those of lanes begin on a cache line. (Put members that are not
/// numbers last; otherwise they shift the numbers off their lines.)
template <class T>
inline constexpr std::size_t line_alignment = sizeof(T) == 64 || sizeof(T) == 32 ? sizeof(T) : alignof(T);

/// `yes()` if the condition holds, else `no()`; only the chosen one is evaluated. Lane types overload this:
/// they may evaluate both and select for each lane.
template <class Yes, class No>
auto either(bool condition, Yes&& yes, No&& no) {
  return condition ? yes() : no();
}

/// Whether a condition holds; for lane types, in every lane.
inline bool everywhere(bool condition) { return condition; }

/// The value without its derivatives.
inline double value_of(double x) { return x; }

/// The larger of two numbers; for lane types, in each lane.
inline double larger(double a, double b) { return a < b ? b : a; }

/// Whether a type is a lane type (lanes.hpp).
template <class T>
constexpr bool is_lanes = false;

}  // namespace borelli
