// The list of methods by name.
#include "dynamics/integrator.hpp"

#include <gtest/gtest.h>

namespace borelli::test {
namespace {

TEST(Integrator, EveryNameMakesItsMethod) {
  for (const std::string& name : integrator_names()) {
    const auto method = make_integrator(name, 1e-6);
    ASSERT_TRUE(method) << name;
    const bool fixed = name == "euler" || name == "rk2" || name == "rk4";
    EXPECT_EQ((*method)->adaptive(), !fixed) << name;
  }
}

TEST(Integrator, AnUnknownNameIsRefusedWithTheKnownOnes) {
  const auto method = make_integrator("rk5", 1e-6);
  ASSERT_FALSE(method);
  EXPECT_EQ(method.error().message(),
            "method 'rk5': is not known; there are euler, rk2, rk4, rk4_adaptive, "
            "dopri5, dop853, gbs");
  EXPECT_EQ(method.error().kind, Error::Kind::use);
}

}  // namespace
}  // namespace borelli::test
