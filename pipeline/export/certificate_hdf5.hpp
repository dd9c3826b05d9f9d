// A certificate as the group /certificate of an HDF5 file.
#pragma once

#include "dynamics/system/certificate.hpp"
#include "pipeline/export/hdf5_columns.hpp"

namespace borelli {

void write_certificate(Hdf5Writer& file, const Certificate& certificate);

/// Reads what write_certificate wrote. `fill` keeps the first error.
void read_certificate(Hdf5Fill& fill, Certificate& certificate);

}  // namespace borelli
