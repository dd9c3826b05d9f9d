// Entries of a matrix row computed at once: several for one state, one per lane for lanes.
#pragma once

#include "dynamics/numbers/lanes.hpp"

namespace borelli {

template <class T>
struct EntriesOf {
  using Type = T;
  static constexpr int count = 1;
  static T load(const T* from) { return *from; }
  static void store(const T& entries, T* to) { *to = entries; }
  static const T& get(const T& entries, int) { return entries; }
};
template <>
struct EntriesOf<double> {
  using Type = Quad;
  static constexpr int count = Quad::count;
  static Quad load(const double* from) { return Quad::load(from); }
  static void store(const Quad& entries, double* to) { entries.store(to); }
  static double get(const Quad& entries, int i) { return entries[i]; }
};

}  // namespace borelli
