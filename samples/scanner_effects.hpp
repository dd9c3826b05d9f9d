// Effects of a scanner on a body's CT numbers: streaks from metal, blur, noise, a round field of view.
#pragma once

#include <cstdint>
#include <vector>

#include "samples/phantom_voxels.hpp"
#include "threads/slabs.hpp"

namespace borelli {

// Runs work(k) for every k below `count`, on several threads.
template <class F>
void each_slice(std::int64_t count, int threads, const F& work) {
  in_turns(count, threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) work(k);
  });
}

/// Fills `scan.grey` from exact CT numbers by voxel index. Adds the streaks, blur, noise and round field of
/// view of `options`, in this order, clamped to -1024 to 3071. Metal voxels are those of `scan.grey` that
/// hold tissue::metal's CT number.
void add_scanner_effects(std::vector<float> value, const ScanOptions& options, Scan& scan);

/// Voxels outside a round field of view become -2000 and lose their label; if `diameter` (mm) is 0, all are
/// in view.
void limit_view(Scan& scan, double diameter, int threads);

}  // namespace borelli
