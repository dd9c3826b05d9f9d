// The list of methods by name.
#include "dynamics/methods/integrator.hpp"

#include <gtest/gtest.h>

namespace borelli::test {
namespace {

TEST(Integrator, EveryNameGivesItsMethod) {
  for (const std::string& name : integrator_names()) {
    const auto method = make_integrator(name, 1e-6);
    ASSERT_TRUE(method) << name;
    const bool adaptive = name == "rk4_adaptive" || name == "dopri5" || name == "dop853" ||
                          name.starts_with("gbs") || name == "gauss16" || name == "cvode" || name == "arkode";
    EXPECT_EQ((*method)->adaptive(), adaptive) << name;
  }
}

TEST(Integrator, RefusesUnknownNamesAndListsKnownOnes) {
  const auto method = make_integrator("rk5", 1e-6);
  ASSERT_FALSE(method);
  EXPECT_EQ(method.error().message(),
            "method 'rk5': is unknown; choose from euler, rk2, rk4, rk4_adaptive, dopri5, dop853, gbs, gbs4, "
            "gbs6, gbs8, gauss16, semi_implicit_euler, verlet, implicit_midpoint, gauss4, gauss6, "
            "generalized_alpha, moreau, cvode, arkode");
  EXPECT_EQ(method.error().kind, Error::Kind::use);
}

}  // namespace
}  // namespace borelli::test
