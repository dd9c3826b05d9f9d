// Functions of the library that calls ITK: the bias field of MR by N4.
#pragma once

#include "error/error.hpp"
#include "segmentation/grid/morphology.hpp"

namespace borelli {

struct ItkFunctions {
  static constexpr const char* library = "borelli_itk";
  /// See bias_field.hpp.
  Result<Volume<float>> (*bias_field)(const Volume<float>& mr, const Mask& mask);
};

}  // namespace borelli
