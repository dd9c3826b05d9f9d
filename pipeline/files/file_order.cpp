#include "pipeline/files/file_order.hpp"

#include <map>
#include <string_view>

namespace borelli {

FileOrder file_order(const Scene& scene, const std::vector<CoordinateInfo>& coordinates) {
  FileOrder order;
  std::map<std::string_view, std::vector<const CoordinateInfo*>> of_solid;
  for (const CoordinateInfo& c : coordinates) of_solid[c.solid].push_back(&c);
  for (const Solid& solid : scene.solids) {
    const auto own = of_solid.find(solid.name);
    if (own == of_solid.end()) continue;
    for (const CoordinateInfo* info : own->second) {
      CoordinateInfo c = *info;
      const auto q = static_cast<int>(order.q.size()), v = static_cast<int>(order.v.size());
      for (int i = 0; i < c.q_size; ++i) order.q.push_back(c.q_index + i);
      for (int i = 0; i < c.v_size; ++i) order.v.push_back(c.v_index + i);
      c.q_index = q;
      c.v_index = v;
      order.coordinates.push_back(std::move(c));
    }
  }
  return order;
}

std::vector<double> in_file_order(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& order) {
  std::vector<double> out;
  for (const Eigen::Index i : order) out.push_back(values[i]);
  return out;
}

}  // namespace borelli
