// Progress messages on standard error when it is not a terminal.
#include "pipeline/verbs/progress.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace borelli {
namespace {

using std::chrono::milliseconds;

TEST(Progress, PrintsLinesAtIntervalsWithoutATerminal) {
  testing::internal::CaptureStderr();
  {
    ProgressBar bar(false, milliseconds(20));
    bar.begin("economy");
    bar.update(0.1);  // too soon
    std::this_thread::sleep_for(milliseconds(25));
    bar.update(0.25);
    bar.update(0.3);  // too soon
    bar.end("3 models");
    std::this_thread::sleep_for(milliseconds(25));
    bar.update(0.9);  // no work runs
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "economy ...\neconomy ... 25 %\neconomy        3 models\n");
}

TEST(Progress, LongWorkShowsTheTimeLeft) {
  EXPECT_EQ(progress_words(0.1, 1e-9), "0 %");  // too early for an estimate
  EXPECT_EQ(progress_words(10, 0.25), "25 %");  // half a minute
  EXPECT_EQ(progress_words(60, 0), "0 %");
  EXPECT_EQ(progress_words(60, 0.004), "0.4 %, about 4 h left");
  EXPECT_EQ(progress_words(60, 0.02), "2 %, about 49 min left");
  EXPECT_EQ(progress_words(30, 1e-9), "1e-07 %, about 951 years left");
}

TEST(Progress, QuickWorkShowsStartAndEnd) {
  testing::internal::CaptureStderr();
  {
    ProgressBar bar(false);
    bar.begin("chart");
    for (int i = 0; i < 100; ++i) bar.update(0.01 * i);
    bar.end("7 runs");
    ProgressBar quiet(true, milliseconds(0));
    quiet.begin("chart");
    quiet.update(0.5);
    quiet.end("7 runs");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "chart ...\nchart          7 runs\n");
}

TEST(Progress, OverlappingWorkIsShownByName) {
  testing::internal::CaptureStderr();
  {
    ProgressBar bar(false, milliseconds(0));
    bar.begin("motion");
    bar.begin("mesh");
    bar.update(0.5, "mesh");
    bar.update(0.2, "motion");
    bar.end("1.00 s", "motion");
    bar.update(0.9, "motion");  // already ended
    bar.update(0.7, "mesh");
    bar.end("2.00 s", "mesh");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "motion ...\nmesh ...\nmesh ... 50 %\nmotion ... 20 %\nmotion         1.00 s\nmesh ... 70 %\n"
            "mesh           2.00 s\n");
}

}  // namespace
}  // namespace borelli
