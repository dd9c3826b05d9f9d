// What ITK does for this program: N4, the bias field of MR.
#pragma once

#include "error/error.hpp"
#include "segmentation/morphology.hpp"

namespace borelli {

struct ItkFunctions {
  static constexpr const char* library = "borelli_itk";
  Result<Volume<float>> (*bias_field)(const Volume<float>& mr, const Mask& mask);  ///< bias_field.hpp
};

}  // namespace borelli
