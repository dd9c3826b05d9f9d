// Thinner slices for a labelled volume: shapes between slices by registration and by signed distances.
//
// Nearest labels would leave steps as high as the slices are thick. Instead:
// 1. Each slice is registered onto the next one by symmetric demons (Penney et al. 2004, IEEE Trans Med Imaging
//    23:883; Thirion 1998, Med Image Anal 2:243), on the grey values of its labels. So thin layers such as skin,
//    and bones that run obliquely, stay connected.
// 2. Where the registered slices differ, the label with the largest interpolated signed distance wins (Raya &
//    Udupa 1990, IEEE Trans Med Imaging 9:32). So the ends of bones become round.
#pragma once

#include <array>
#include <cstdint>

#include "segmentation/volume/volume.hpp"

namespace borelli::suite {

/// Splits each slice into `factor` slices of equal thickness; the first and the last half slice stay as they
/// are. `labels`: 0 to 255, pixels of equal breadth and depth; `grey`: a grey value for each label, between
/// about 0 and 1. The result does not depend on the number of threads.
Volume<std::int16_t> finer_slices(const Volume<std::int16_t>& labels, const std::array<float, 256>& grey,
                                  int factor, int threads = 0);

}  // namespace borelli::suite
