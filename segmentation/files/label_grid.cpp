#include "segmentation/files/label_grid.hpp"

#include <cmath>
#include <filesystem>

#include "segmentation/dicom_segmentation.hpp"
#include "segmentation/image_file.hpp"

namespace borelli {
namespace {

Result<Grid> grid_of_labels(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored) || is_dicom_file(path))
    return dicom_segmentation_grid(path);
  const auto header = read_image_header(path);
  if (!header) return tl::unexpected(header.error());
  return header->grid;
}

}  // namespace

Result<void> check_label_grid(const std::string& labels, const Grid& scan, const std::string& scan_name) {
  const auto grid = grid_of_labels(labels);
  if (!grid) return tl::unexpected(grid.error());
  constexpr double allowed = 0.05;  // of a voxel; who reads the labels may ask for more
  const Eigen::Matrix3d steps = scan.axes.inverse() * grid->axes, whole = steps.array().round().matrix();
  const Eigen::Vector3d origin = scan.index(grid->origin);
  double off = (origin.array() - origin.array().round()).abs().maxCoeff();
  for (Eigen::Index c = 0; c < 3; ++c)
    off = std::max(off, (steps - whole).col(c).cwiseAbs().maxCoeff() *
                            static_cast<double>(grid->size[static_cast<std::size_t>(c)] - 1));
  const bool turned = whole.cwiseAbs().colwise().sum().isOnes() && whole.cwiseAbs().rowwise().sum().isOnes();
  if (turned && off <= allowed) return {};
  return bad_use(labels, "lies on another grid than " + scan_name + "; resample one onto the other");
}

}  // namespace borelli
