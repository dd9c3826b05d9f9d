#include "pipeline/recordings/c3d_events.hpp"

#include <gtest/gtest.h>

#include "tests/pipeline/recordings/c3d_trial.hpp"
#include "tests/pipeline/recordings/c3d_writer.hpp"

namespace borelli::test::c3d_events_test {
namespace {

using test::C3dWriter;

C3dWriter hundred_frames(C3dWriter::Processor processor) {
  C3dWriter writer;
  writer.processor = processor;
  writer.first_frame = 51;  // the recording starts at 0.5 s
  writer.frames.assign(100, {{1, 2, 3, 0}});
  writer.usual_parameters({"A"});
  return writer;
}

TEST(C3dEvents, HeaderCountsFromTheFirstFrameAndTheGroupFromFrameOne) {
  for (const auto processor : {C3dWriter::intel, C3dWriter::dec, C3dWriter::mips}) {
    C3dWriter writer = hundred_frames(processor);
    writer.header_events = {{0.75, "RTO"}, {0.25, "RHS1"}};
    writer.integer("EVENT:USED", 2);
    writer.reals("EVENT:TIMES", {0, 1.0, 1, 0.5}, {2, 2});  // 1.0 s, and one minute and a half second
    writer.text("EVENT:LABELS", {"Foot Strike", "Foot Off"});
    writer.text("EVENT:CONTEXTS", {"Left", "Right"});
    writer.text("EVENT:SUBJECTS", {"Anna", "Anna"});
    writer.text("EVENT:DESCRIPTIONS", {"first contact", "last contact"});
    const auto events = test::read_c3d_bytes(writer.bytes())->events;
    ASSERT_EQ(events.size(), 4);
    EXPECT_NEAR(events[0].time, 0.75, 1e-6);
    EXPECT_EQ(events[0].label, "RHS1");
    EXPECT_NEAR(events[1].time, 1.0, 1e-6);
    EXPECT_EQ(events[1].label, "Foot Strike");
    EXPECT_EQ(events[1].context, "Left");
    EXPECT_EQ(events[1].subject, "Anna");
    EXPECT_EQ(events[1].description, "first contact");
    EXPECT_NEAR(events[2].time, 1.25, 1e-6);
    EXPECT_EQ(events[2].label, "RTO");
    EXPECT_NEAR(events[3].time, 60.5, 1e-6);
  }
}

TEST(C3dEvents, EventInHeaderAndGroupIsReadOnce) {
  C3dWriter writer = hundred_frames(C3dWriter::intel);
  writer.header_events = {{0.5, "RHS"}};
  writer.integer("EVENT:USED", 1);
  writer.reals("EVENT:TIMES", {0, 1.0}, {2, 1});
  writer.text("EVENT:LABELS", {"Foot Strike"});
  const auto events = test::read_c3d_bytes(writer.bytes())->events;
  ASSERT_EQ(events.size(), 1);
  EXPECT_EQ(events[0].label, "Foot Strike");
}

TEST(C3dEvents, WarnsOfACountLargerThanTheTimes) {
  C3dWriter writer = hundred_frames(C3dWriter::intel);
  writer.integer("EVENT:USED", 30000);
  writer.reals("EVENT:TIMES", {0, 1.0, 0, 1.2}, {2, 2});
  const auto file = test::read_c3d_bytes(writer.bytes());
  EXPECT_EQ(file->events.size(), 2);
  EXPECT_EQ(file->events[1].label, "");
  EXPECT_TRUE(test::has_warning(file->warnings, "EVENT:USED is 30000, but EVENT:TIMES contains 2"));
}

}  // namespace
}  // namespace borelli::test::c3d_events_test
