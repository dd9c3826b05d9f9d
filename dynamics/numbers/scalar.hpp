// What the engine asks of a scalar. The equations are written once, over a type T: double, a dual number
// (dual.hpp) that carries derivatives along, or several doubles side by side (lanes.hpp).
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "error/eigen_layout.hpp"

namespace borelli {

/// A matrix whose rows lie one after the other in memory.
template <class T>
using RowsOf = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Of structures that are many: those of numbers side by side begin where a line of the cache does. (Keep
/// what is no number at their ends: it would push the others off their lines.)
template <class T>
inline constexpr std::size_t line_alignment = sizeof(T) == 64 || sizeof(T) == 32 ? sizeof(T) : alignof(T);

/// `yes()` where the condition holds, else `no()`. Only the one that is asked for is evaluated; a type of
/// several numbers overloads this to evaluate both and take of each what is asked.
template <class Yes, class No>
auto either(bool condition, Yes&& yes, No&& no) {
  return condition ? yes() : no();
}

/// Whether a condition holds; of a type of several numbers, for each of them.
inline bool everywhere(bool condition) { return condition; }

/// The number itself, without its derivatives.
inline double value_of(double x) { return x; }

/// The larger of two numbers; of a type of several, of each.
inline double larger(double a, double b) { return a < b ? b : a; }

/// Whether a type is of several numbers (lanes.hpp).
template <class T>
constexpr bool is_lanes = false;

}  // namespace borelli
