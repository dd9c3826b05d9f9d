// What a scanner adds to a body's CT numbers: streaks from metal, blur, noise, a round field of view.
#pragma once

#include <cstdint>
#include <vector>

#include "samples/phantom_voxels.hpp"
#include "threads/slabs.hpp"

namespace borelli {

// Runs work(k) for every k below `count`, on some threads.
template <class F>
void each_slice(std::int64_t count, int threads, const F& work) {
  in_turns(count, threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) work(k);
  });
}

/// Fills `scan.grey` from exact CT numbers by offset: streaks, blur, noise and the round view of `options`,
/// in this order, clamped to -1024 to 3071. Voxels of `scan.grey` that hold tissue::metal's CT number are
/// metal.
void add_scanner_effects(std::vector<float> value, const ScanOptions& options, Scan& scan);

/// Outside a round view voxels hold -2000 and belong to nothing; all is in view if `diameter` (mm) is 0.
void limit_view(Scan& scan, double diameter, int threads);

}  // namespace borelli
