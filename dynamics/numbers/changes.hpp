// Detects whether any of a set of numbers has changed.
#pragma once

#include "dynamics/numbers/lanes.hpp"

namespace borelli {

/// Compares numbers bit by bit, so that changes to or from NaN count too.
class Changes {
 public:
  template <class Value>
  void add(const Value& now, const Value& before) {
    constexpr int count = sizeof(Value) / sizeof(double);
    static_assert(sizeof(Value) == count * sizeof(double), "numbers alone, without gaps");
    const char *a = reinterpret_cast<const char*>(&now), *b = reinterpret_cast<const char*>(&before);
    int i = 0;
    for (; i + Quad::count <= count; i += Quad::count) {
      Words x, y;
      __builtin_memcpy(&x, a + i * sizeof(double), sizeof x);
      __builtin_memcpy(&y, b + i * sizeof(double), sizeof y);
      differ_ |= x ^ y;
    }
    for (; i < count; ++i) {
      long long x, y;
      __builtin_memcpy(&x, a + i * sizeof(double), sizeof x);
      __builtin_memcpy(&y, b + i * sizeof(double), sizeof y);
      rest_ |= x ^ y;
    }
  }
  bool any() const { return rest_ != 0 || !Quad::Mask(differ_ == 0).all(); }

 private:
  using Words = Quad::Mask::Vector;
  Words differ_{};
  long long rest_ = 0;
};

}  // namespace borelli
