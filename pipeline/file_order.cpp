#include "pipeline/file_order.hpp"

namespace borelli {

FileOrder file_order(const Scene& scene, const std::vector<CoordinateInfo>& coordinates) {
  FileOrder order;
  for (const Solid& solid : scene.solids)
    for (CoordinateInfo c : coordinates) {
      if (c.solid != solid.name) continue;
      const auto q = static_cast<int>(order.q.size()), v = static_cast<int>(order.v.size());
      for (int i = 0; i < c.q_size; ++i) order.q.push_back(c.q_index + i);
      for (int i = 0; i < c.v_size; ++i) order.v.push_back(c.v_index + i);
      c.q_index = q;
      c.v_index = v;
      order.coordinates.push_back(std::move(c));
    }
  return order;
}

std::vector<double> in_file_order(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& order) {
  std::vector<double> out;
  for (const Eigen::Index i : order) out.push_back(values[i]);
  return out;
}

}  // namespace borelli
