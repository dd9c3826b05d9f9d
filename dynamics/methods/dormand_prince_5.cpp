#include "dynamics/methods/embedded_runge_kutta.hpp"

namespace borelli {

namespace dopri5 {

constexpr double nodes[] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1};
constexpr double weights[] = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84};
constexpr double coupling[] = {0,
                               0,
                               0,
                               0,
                               0,
                               0,  //
                               1.0 / 5,
                               0,
                               0,
                               0,
                               0,
                               0,  //
                               3.0 / 40,
                               9.0 / 40,
                               0,
                               0,
                               0,
                               0,  //
                               44.0 / 45,
                               -56.0 / 15,
                               32.0 / 9,
                               0,
                               0,
                               0,  //
                               19372.0 / 6561,
                               -25360.0 / 2187,
                               64448.0 / 6561,
                               -212.0 / 729,
                               0,
                               0,  //
                               9017.0 / 3168,
                               -355.0 / 33,
                               46732.0 / 5247,
                               49.0 / 176,
                               -5103.0 / 18656,
                               0};
// Fifth-order weights minus fourth-order weights.
constexpr double error[] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                            -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
constexpr double dense_weights[] = {-12715105075.0 / 11282082432,  0,
                                    87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                    701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                    69997945.0 / 29380423};

}  // namespace dopri5

const EmbeddedTableau& dormand_prince_5() {
  using namespace dopri5;
  static constexpr EmbeddedTableau tableau{.step = {5, 6, nodes, weights, coupling},
                                           .error = error,
                                           .coarse_error = {},
                                           .dense_order = 4,
                                           .dense_stages = 0,
                                           .dense_nodes = {},
                                           .dense_coupling = {},
                                           .dense_weights = dense_weights,
                                           .limits = {.beta = 0.04, .shrink = 0.2, .grow = 10},
                                           .stability = 3.25};
  return tableau;
}

}  // namespace borelli
