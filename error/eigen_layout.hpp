// Eigen aligns its types and what it allocates by the instructions that a file is compiled for (AVX: 32
// bytes). A program that uses this library must agree with it whatever its own flags are: CMake's borelli::
// targets define both macros.
#pragma once

#include <Eigen/Core>

static_assert(
    EIGEN_DEFAULT_ALIGN_BYTES == 64 && EIGEN_MAX_STATIC_ALIGN_BYTES == 16,
    "define EIGEN_MAX_ALIGN_BYTES=64 and EIGEN_MAX_STATIC_ALIGN_BYTES=16 before Eigen is included, as "
    "CMake's borelli:: targets do: the library's types are laid out so");
