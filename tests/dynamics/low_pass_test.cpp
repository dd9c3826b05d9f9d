// The low-pass filter against SciPy's Butterworth filter and against the closed form on long sine waves.
#include "dynamics/inverse/low_pass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace borelli::test::low_pass_test {
namespace {

SampledSignal sampled(int n, double step, double (*f)(double)) {
  SampledSignal signal{{}, Eigen::MatrixXd(n, 1)};
  for (int i = 0; i < n; ++i) {
    signal.times.push_back(i * step);
    signal.values(i, 0) = f(i * step);
  }
  return signal;
}

TEST(LowPass, FollowsOpenSimsRecipe) {
  const double values[24] = {0.3,       0.237965, 0.570278,  1.231997,  0.843787,  0.766636,
                             0.975294,  0.174913, -0.196578, -0.142902, -0.921121, -1.085309,
                             -0.696843, -1.05197, -0.760439, 0.019525,  -0.056116, 0.369512,
                             1.092142,  0.791154, 0.869363,  1.152523,  0.404101,  0.107534};
  SampledSignal signal{{}, Eigen::MatrixXd(24, 1)};
  for (int i = 0; i < 24; ++i) {
    signal.times.push_back(0.01 * i);
    signal.values(i, 0) = values[i];
  }
  const auto filtered = low_pass(signal, 12);
  ASSERT_TRUE(filtered);
  ASSERT_EQ(filtered->times.size(), 48u);  // 12 more at each end
  EXPECT_NEAR(filtered->times[12], 0, 1e-12);
  // scipy.signal.butter(3, 0.24), odd padding of 12, forwards and backwards, the first three samples are kept
  const double expected[5] = {0.29407868452899877, 0.5281921739658113, 0.3312537220865931,
                              -0.27752152830058135, 0.08167374697332838};
  const int at[5] = {0, 1, 7, 15, 23};
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(filtered->values(12 + at[k], 0), expected[k], 1e-12);
}

TEST(LowPass, HalvesASineAtTheCutOffWithoutDelay) {
  // each pass damps to 1 / sqrt 2 at the cut-off
  const auto filtered =
      low_pass(sampled(4001, 0.002, [](double t) { return std::sin(2 * std::numbers::pi * 6 * t); }), 6);
  ASSERT_TRUE(filtered);
  for (std::size_t i = 0; i < filtered->times.size(); ++i) {
    const double t = filtered->times[i];
    if (t > 3 && t < 5) {
      EXPECT_NEAR(filtered->values(Eigen::Index(i), 0), 0.5 * std::sin(2 * std::numbers::pi * 6 * t), 1e-9);
    }
  }
}

TEST(LowPass, LeavesAStraightLineAsItIs) {
  // after three seconds of padding the start-up transient has died away
  const auto filtered = low_pass(sampled(600, 0.01, [](double t) { return 3 - 2 * t; }), 6);
  ASSERT_TRUE(filtered);
  for (std::size_t i = 500; i < 700; ++i)
    EXPECT_NEAR(filtered->values(Eigen::Index(i), 0), 3 - 2 * filtered->times[i], 1e-10);
}

TEST(LowPass, ResamplesUnevenTimes) {
  SampledSignal signal = sampled(301, 0.01, [](double t) { return std::sin(2 * t); });
  for (std::size_t i = 0; i < signal.times.size(); ++i) {
    signal.times[i] += i % 2 ? 0.001 : 0;
    signal.values(Eigen::Index(i), 0) = std::sin(2 * signal.times[i]);
  }
  const auto filtered = low_pass(signal, 20);
  ASSERT_TRUE(filtered);
  for (std::size_t i = 0; i < filtered->times.size(); ++i)
    if (filtered->times[i] > 1 && filtered->times[i] < 2) {
      EXPECT_NEAR(filtered->values(Eigen::Index(i), 0), std::sin(2 * filtered->times[i]), 1e-6);
    }
}

TEST(LowPass, RefusesACutOffOfHalfTheSamplingRateOrMore) {
  const SampledSignal signal = sampled(50, 0.01, [](double t) { return t; });
  EXPECT_FALSE(low_pass(signal, 50));
  EXPECT_FALSE(low_pass(signal, 0));
  EXPECT_FALSE(low_pass(signal, -1));
  EXPECT_TRUE(low_pass(signal, 49.9));
  EXPECT_FALSE(low_pass(sampled(4, 0.01, [](double t) { return t; }), 5));
}

}  // namespace
}  // namespace borelli::test::low_pass_test
