#include "dynamics/constraints/local_coordinates.hpp"

#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"
#include "dynamics/numbers/rotation_vector.hpp"

namespace borelli {

namespace {

template <class T>
void find_positions(const System& system, const T* q0, const T* x, T* q) {
  using std::sqrt;
  for (const CoordinateInfo& info : system.coordinates) {
    const T* from = q0 + info.q_index;
    const T* by = x + info.v_index;
    T* to = q + info.q_index;
    if (info.q_size == 1) {
      *to = *from + *by;
      continue;
    }
    const QuaternionOf<T> turned = product(Eigen::Map<const QuaternionOf<T>>(from),
                                           exponential(Eigen::Map<const Eigen::Vector3<T>>(by)));
    Eigen::Map<QuaternionOf<T>>{to} = turned / T(sqrt(turned.squaredNorm()));
  }
}

template <class T>
void find_rate(const System& system, const T* x, const T* v, T* rate) {
  using Vector = Eigen::Vector3<T>;
  for (const CoordinateInfo& info : system.coordinates) {
    const int i = info.v_index;
    if (info.v_size == 1)
      rate[i] = v[i];
    else
      Eigen::Map<Vector>(rate + i) =
          rotation_vector_rate(Eigen::Map<const Vector>(x + i), Eigen::Map<const Vector>(v + i));
  }
}

}  // namespace

void from_local_coordinates(const System& system, const double* q0, const double* x, double* q) {
  find_positions(system, q0, x, q);
}
void local_rate(const System& system, const double* x, const double* v, double* rate) {
  find_rate(system, x, v, rate);
}
#define BORELLI_CHART_OVER(T)                                                            \
  void from_local_coordinates(const System& system, const T* q0, const T* x, T* q) {     \
    in_registers([]<int>(auto&... each) { find_positions(each...); }, system, q0, x, q); \
  }                                                                                      \
  void local_rate(const System& system, const T* x, const T* v, T* rate) {               \
    in_registers([]<int>(auto&... each) { find_rate(each...); }, system, x, v, rate);    \
  }
BORELLI_CHART_OVER(Lanes)
BORELLI_CHART_OVER(Quad)

}  // namespace borelli
