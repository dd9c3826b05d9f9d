#include "segmentation/on_demand/itk.hpp"

#include <itkImage.h>
#include <itkN4BiasFieldCorrectionImageFilter.h>

#include <algorithm>
#include <cmath>

#include "process/on_demand.hpp"

namespace borelli {
namespace {

Result<Volume<float>> bias_field(const Volume<float>& mr, const Mask& mask) try {
  using Image = itk::Image<float, 3>;
  using MaskImage = itk::Image<unsigned char, 3>;
  const auto place = [&](auto image) {
    // directions and origin do not matter to the field: it is one of indices
    typename std::remove_reference_t<decltype(*image)>::SizeType size;
    typename std::remove_reference_t<decltype(*image)>::SpacingType spacing;
    for (unsigned c = 0; c < 3; ++c) {
      size[c] = static_cast<itk::SizeValueType>(mr.grid.size[c]);
      spacing[c] = mr.grid.axes.col(static_cast<int>(c)).norm();
    }
    image->SetRegions(size);
    image->SetSpacing(spacing);
    image->Allocate();
  };
  const auto image = Image::New();
  const auto inside = MaskImage::New();
  place(image.GetPointer()), place(inside.GetPointer());
  double sum = 0;
  std::size_t count = 0;
  const float greatest = *std::ranges::max_element(mr.voxels);
  for (std::size_t o = 0; o < mr.voxels.size(); ++o) {
    // logarithms are taken of it
    const float value = std::max(mr.voxels[o], 1e-4F * greatest);
    image->GetBufferPointer()[o] = value;
    inside->GetBufferPointer()[o] = mask.voxels[o] != 0;
    if (mask.voxels[o]) ++count;
  }
  if (count == 0 || !(greatest > 0))
    return failure("bias field", "cannot be estimated: the volume contains no body");

  using Filter = itk::N4BiasFieldCorrectionImageFilter<Image, MaskImage, Image>;
  const auto filter = Filter::New();
  filter->SetInput(image);
  filter->SetMaskImage(inside);
  filter->SetMaskLabel(1);
  filter->SetUseMaskLabel(true);
  filter->SetNumberOfWorkUnits(1);  // sums in one order: the same field every time
  Filter::ArrayType levels;
  levels.Fill(3);
  filter->SetNumberOfFittingLevels(levels);
  Filter::VariableSizeArrayType iterations(3);
  iterations.Fill(20);
  filter->SetMaximumNumberOfIterations(iterations);
  filter->SetConvergenceThreshold(1e-3F);
  filter->Update();
  const auto logarithm = filter->ReconstructBiasField(filter->GetLogBiasFieldControlPointLattice());

  Volume<float> field{mr.grid, std::vector<float>(mr.voxels.size())};
  const float* log_field = logarithm->GetBufferPointer();
  for (std::size_t o = 0; o < field.voxels.size(); ++o)
    if (mask.voxels[o]) sum += static_cast<double>(log_field[o]);
  const auto mean = static_cast<float>(sum / static_cast<double>(count));
  // beyond the body the splines are held by nothing
  for (std::size_t o = 0; o < field.voxels.size(); ++o)
    field.voxels[o] = std::exp(std::clamp(log_field[o] - mean, -2.F, 2.F));
  return field;
} catch (const itk::ExceptionObject& trouble) {
  return failure("bias field", std::string("cannot be estimated: ") + trouble.GetDescription());
}

}  // namespace
}  // namespace borelli

BORELLI_ON_DEMAND(borelli::ItkFunctions){.bias_field = borelli::bias_field};
