#include "segmentation/files/voxel_size.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

bool is_given(double length) { return std::isfinite(length) && length > 0; }

// Headers round, e.g. pixdim to float32 or to a few decimals.
bool same_length(double a, double b, double within) { return std::abs(a - b) <= within * std::max(a, b); }

bool all_ones(const Eigen::Vector3d& size) { return ((size.array() - 1).abs() < 1e-3).all(); }
bool is_complete(const Eigen::Vector3d& size) { return size.allFinite() && (size.array() > 0).all(); }

int votes(const SizeField& field) { return field.may_differ ? 1 : 2; }

// Whether a field is all ones, which programs leave where they set nothing, and another contradicts it.
bool ones_are_contradicted(const std::vector<SizeField>& fields) {
  return std::ranges::any_of(fields, [](const SizeField& field) { return all_ones(field.size); }) &&
         std::ranges::any_of(
             fields, [](const SizeField& field) { return is_complete(field.size) && !all_ones(field.size); });
}

// The length along `axis` with most votes; NaN: a tie, or a field that may differ would overrule ones.
double most_voted(const std::vector<SizeField>& fields, int axis, bool without_ones) {
  double best = std::nan("");
  int most = 0;
  for (const SizeField& candidate : fields) {
    const double length = candidate.size[axis];
    if (!is_given(length) || (without_ones && all_ones(candidate.size))) continue;
    int count = 0;
    for (const SizeField& field : fields)
      if (is_given(field.size[axis]) && !(without_ones && all_ones(field.size)) &&
          same_length(field.size[axis], length, 0.01))
        count += votes(field);
    if (count > most)
      most = count, best = length;
    else if (count == most && !same_length(length, best, 0.01))
      best = std::nan("");
  }
  return without_ones && most < votes({}) ? std::nan("") : best;
}

std::string said_by(const std::vector<SizeField>& fields) {
  std::string text;
  for (const SizeField& field : fields) {
    std::string lengths;
    for (int axis = 0; axis < 3; ++axis)
      lengths +=
          (axis ? " x " : "") + (is_given(field.size[axis]) ? fmt::format("{:.5g}", field.size[axis]) : "?");
    text += (text.empty() ? "" : ", ") + fmt::format("{} {}", field.name, lengths);
  }
  return text;
}

}  // namespace

Result<Eigen::Vector3d> voxel_size(const std::string& path, const std::vector<SizeField>& fields,
                                   std::vector<std::string>& warnings) {
  if (fields.size() == 1) return fields.front().size;
  Eigen::Vector3d size;
  bool differ = false;
  const bool without_ones = ones_are_contradicted(fields);
  for (int axis = 0; axis < 3; ++axis) {
    const bool unsaid =
        std::ranges::none_of(fields, [&](const SizeField& field) { return is_given(field.size[axis]); });
    if (unsaid) return failure(path, fmt::format("does not state the voxel size along axis {}", axis + 1));
    size[axis] = most_voted(fields, axis, without_ones);
    if (!is_given(size[axis]))
      return failure(
          path, fmt::format(
                    "gives contradictory voxel sizes ({}), and masses depend on them; correct the wrong one",
                    said_by(fields)));
    for (const SizeField& field : fields)
      differ = differ || (is_given(field.size[axis]) && !same_length(field.size[axis], size[axis], 1e-3));
  }
  if (differ)
    warnings.push_back(
        fmt::format("the header gives different voxel sizes ({}); {:.5g} x {:.5g} x {:.5g} was used, and "
                    "lengths and masses depend on it",
                    said_by(fields), size[0], size[1], size[2]));
  return size;
}

void resize_axes(Eigen::Matrix3d& axes, const Eigen::Vector3d& size) {
  for (int axis = 0; axis < 3; ++axis) {
    const double length = axes.col(axis).norm();
    if (!same_length(length, size[axis], 1e-3)) axes.col(axis) *= size[axis] / length;
  }
}

}  // namespace borelli
