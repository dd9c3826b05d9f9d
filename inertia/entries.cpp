#include "inertia/entries.hpp"

#include <array>
#include <limits>

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

void add_tensor(std::vector<Entry>& entries, const std::string& prefix, const Matrix3d& I, bool of_the_body) {
  constexpr std::array<const char*, 3> axis{"x", "y", "z"};
  for (const auto& [r, c] : {std::pair{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}})
    entries.push_back(
        {prefix + "_I" + axis[static_cast<std::size_t>(r)] + axis[static_cast<std::size_t>(c)] + "_kgm2",
         I(r, c), of_the_body});
}

void add_three(std::vector<Entry>& entries, const std::array<const char*, 3>& names, const Vector3d& v,
               bool of_the_body = true) {
  for (int n = 0; n < 3; ++n) entries.push_back({names[static_cast<std::size_t>(n)], v[n], of_the_body});
}

}  // namespace

std::vector<Entry> entries_of(const InertiaTable& table, const InertiaRow& row) {
  const bool there = row.completeness != Completeness::absent;
  const auto known = [&](double value) { return there ? value : not_known; };
  const Vector3d nothing = Vector3d::Constant(not_known);
  const Matrix3d no_tensor = Matrix3d::Constant(not_known);
  const auto anatomical = anatomical_numbers(row);
  std::vector<Entry> entries{{"volume_m3", known(row.volume)},
                             {"mass_kg", known(row.inertial.mass)},
                             {"mass_pct", known(100 * table.share(row))}};
  add_three(entries, {"centre_x_m", "centre_y_m", "centre_z_m"}, there ? row.inertial.centre : nothing,
            false);
  add_tensor(entries, "patient", there ? row.inertial.tensor : no_tensor, false);
  add_tensor(entries, "anatomical", anatomical ? anatomical->tensor : no_tensor, true);
  add_three(entries, {"principal_I1_kgm2", "principal_I2_kgm2", "principal_I3_kgm2"},
            there ? row.inertial.principal().moments : nothing);
  entries.push_back({"length_m", anatomical && anatomical->length > 0 ? anatomical->length : not_known});
  entries.push_back({"centre_pct", anatomical ? 100 * anatomical->centre_along : not_known});
  add_three(entries, {"rx_pct", "ry_pct", "rz_pct"},
            anatomical ? Vector3d(100 * anatomical->radii) : nothing);
  return entries;
}

}  // namespace borelli
