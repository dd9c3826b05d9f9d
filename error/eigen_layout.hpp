// Eigen's alignment of types and of allocated memory depends on compiler flags (-mavx: 32 bytes). The library
// and a program that uses it crash if they differ. CMake's borelli:: targets define both macros.
#pragma once

#include <Eigen/Core>

static_assert(
    EIGEN_DEFAULT_ALIGN_BYTES == 64 && EIGEN_MAX_STATIC_ALIGN_BYTES == 16,
    "define EIGEN_MAX_ALIGN_BYTES=64 and EIGEN_MAX_STATIC_ALIGN_BYTES=16 before Eigen is included, as "
    "CMake's borelli:: targets do: the library was compiled with them");
