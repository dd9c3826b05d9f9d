#include "dynamics/chart.hpp"

#include "dynamics/rotation_vector.hpp"

namespace borelli {

using Eigen::Vector3d;

void from_chart(const System& system, const double* q0, const double* x, double* q) {
  for (const CoordinateInfo& info : system.coordinates) {
    const double* from = q0 + info.q_index;
    const double* by = x + info.v_index;
    double* to = q + info.q_index;
    if (info.q_size == 1) {
      *to = *from + *by;
      continue;
    }
    const Quaternion turned =
        product(Eigen::Map<const Quaternion>(from), exponential(Eigen::Map<const Vector3d>(by)));
    Eigen::Map<Quaternion>{to} = turned / turned.norm();
  }
}

void chart_rate(const System& system, const double* x, const double* v, double* rate) {
  for (const CoordinateInfo& info : system.coordinates) {
    const int i = info.v_index;
    if (info.v_size == 1)
      rate[i] = v[i];
    else
      Eigen::Map<Vector3d>(rate + i) =
          rotation_vector_rate(Eigen::Map<const Vector3d>(x + i), Eigen::Map<const Vector3d>(v + i));
  }
}

}  // namespace borelli
