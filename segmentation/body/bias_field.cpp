#include "segmentation/body/bias_field.hpp"

#include "process/on_demand.hpp"
#include "segmentation/on_demand/itk.hpp"

namespace borelli {

Result<Volume<float>> bias_field(const Volume<float>& mr, const Mask& mask) {
  const auto itk = on_demand<ItkFunctions>();
  if (!itk) return tl::unexpected(itk.error());
  return (*itk)->bias_field(mr, mask);
}

}  // namespace borelli
