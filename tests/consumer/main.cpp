// Uses public names of two folders; answers 0 when they do what they say.
#include <cmath>
#include <numbers>

#include "dynamics/shape.hpp"
#include "segmentation/cuts.hpp"

int main() {
  const bool no_cuts = borelli::cut_planes({}).empty();
  const auto ball = borelli::inertial_of_density({.form = borelli::Sphere{0.5}}, 1000);
  const bool weighs_right = ball && std::abs(ball->mass - 1000 * std::numbers::pi / 6) < 1e-9;
  return no_cuts && weighs_right ? 0 : 1;
}
