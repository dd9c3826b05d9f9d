#include "pipeline/recordings/c3d_layout.hpp"

#include <gtest/gtest.h>

#include "tests/pipeline/recordings/c3d_trial.hpp"
#include "tests/pipeline/recordings/c3d_writer.hpp"

namespace borelli::test::c3d_layout_test {
namespace {

using test::C3dWriter;

// Two points, three channels, four samples of each per frame.
C3dWriter small_file(bool real = true) {
  const int frames = 20;
  C3dWriter writer;
  writer.real = real;
  writer.channels = 3, writer.samples = 4;
  for (int i = 0; i < frames; ++i) writer.frames.push_back({{1, 2, 3, 0}, {4, 5, 6, 0}});
  writer.numbers.assign(static_cast<std::size_t>(4 * frames), {1, 2, 3});
  writer.usual_parameters({"A", "B"});
  return writer;
}

Result<C3dLayout> layout_of(const C3dWriter& writer, std::vector<std::string>& warnings,
                            std::size_t cut = 0) {
  std::string bytes = writer.bytes();
  bytes.resize(bytes.size() - cut);
  const auto parameters =
      read_c3d_parameters(bytes, 512, bytes.size(), C3dProcessor::intel, "a.c3d", warnings);
  return c3d_layout(bytes, C3dProcessor::intel, *parameters, "a.c3d", warnings);
}

TEST(C3dLayout, CountsPlaceAndRateAreThoseOfTheFile) {
  for (const bool real : {false, true}) {
    const C3dWriter writer = small_file(real);
    std::vector<std::string> warnings;
    const C3dLayout layout = layout_of(writer, warnings).value();
    EXPECT_EQ(layout.points, 2);
    EXPECT_EQ(layout.channels, 3);
    EXPECT_EQ(layout.samples, 4);
    EXPECT_EQ(layout.frames, 20);
    EXPECT_EQ(layout.data % 512, 0);
    EXPECT_EQ(layout.frame_bytes(), (2 * 4 + 3 * 4) * (real ? 4 : 2));
    EXPECT_EQ(layout.rate, 100);
    EXPECT_FLOAT_EQ(static_cast<float>(layout.scale), 0.05F);
    EXPECT_EQ(layout.real, real);
    EXPECT_TRUE(warnings.empty());
  }
}

TEST(C3dLayout, ParametersWinOverAnOldHeader) {
  C3dWriter writer = small_file();
  writer.header_frames = 19;
  writer.header_points = 1;
  std::vector<std::string> warnings;
  const C3dLayout layout = layout_of(writer, warnings).value();
  EXPECT_EQ(layout.frames, 20);
  EXPECT_EQ(layout.points, 2);
}

TEST(C3dLayout, HeaderWinsWhereOnlyItFitsTheFile) {
  C3dWriter writer = small_file();
  writer.remove("POINT", "FRAMES");
  writer.integer("POINT:FRAMES", 500);
  std::vector<std::string> warnings;
  EXPECT_EQ(layout_of(writer, warnings)->frames, 20);
  EXPECT_TRUE(test::has_warning(warnings, "header and parameters differ: 500 frames of 2 points"));

  writer = small_file();
  writer.remove("POINT", "USED");
  writer.integer("POINT:USED", 300);
  EXPECT_EQ(layout_of(writer, warnings)->points, 2);
}

TEST(C3dLayout, ScaleOfTheHeaderWins) {
  C3dWriter writer = small_file(false);
  writer.header_scale = 0.2;
  std::vector<std::string> warnings;
  EXPECT_FLOAT_EQ(static_cast<float>(layout_of(writer, warnings)->scale), 0.2F);
  EXPECT_TRUE(test::has_warning(warnings,
                                "POINT:SCALE is 0.05, but the header's scale is 0.2; the header's was used"));
  warnings.clear();
  writer.header_scale = 0;
  EXPECT_FLOAT_EQ(static_cast<float>(layout_of(writer, warnings)->scale), 0.05F);
  EXPECT_TRUE(warnings.empty());
}

TEST(C3dLayout, SignOfThePointScaleWinsWhereOnlyItFitsTheFile) {
  C3dWriter writer = small_file(false);
  writer.header_scale = -1;  // floating-point numbers would take twice the bytes
  std::vector<std::string> warnings;
  EXPECT_FALSE(layout_of(writer, warnings)->real);
  EXPECT_FLOAT_EQ(static_cast<float>(layout_of(writer, warnings)->scale), 0.05F);
}

// A recording of 70 000 frames of one number: longer than a 16-bit count.
TEST(C3dLayout, LongRecordingsAreCountedByTheirOwnParameters) {
  const int frames = 70000;
  C3dWriter writer;
  writer.real = false, writer.channels = 1, writer.first_frame = 1;
  writer.frames.assign(frames, {});
  writer.numbers.assign(frames, {7});
  writer.header_frames = 65535;
  const auto with = [&](const std::function<void(C3dWriter&)>& add) {
    C3dWriter out = writer;
    out.usual_parameters({});
    out.remove("POINT", "FRAMES");
    add(out);
    return out;
  };
  std::vector<std::string> warnings;
  EXPECT_EQ(layout_of(with([](C3dWriter& w) {
                        w.integer("POINT:FRAMES", 65535);
                        w.real_number("POINT:LONG_FRAMES", frames);
                      }),
                      warnings)
                ->frames,
            frames);
  const auto trial = [](C3dWriter& w) {  // frames 2 to 70 001: low word, high word
    w.integers("TRIAL:ACTUAL_START_FIELD", {2, 0}, {2});
    w.integers("TRIAL:ACTUAL_END_FIELD", {70001 - 65536, 1}, {2});
  };
  for (const int counted : {65535, frames - 65536}) {  // as in the guide, and as some programs write
    const auto layout =
        layout_of(with([&](C3dWriter& w) { trial(w), w.integer("POINT:FRAMES", counted); }), warnings);
    EXPECT_EQ(layout->frames, frames);
    EXPECT_EQ(layout->first_frame, 2);
  }
  EXPECT_EQ(layout_of(with([](C3dWriter& w) { w.real_number("POINT:FRAMES", frames); }), warnings)->frames,
            frames);
  EXPECT_TRUE(warnings.empty());
  // POINT:FRAMES ends at 65535, so the file's size gives the count. Zeros that fill the last block do not
  // count.
  EXPECT_EQ(layout_of(with([](C3dWriter& w) { w.integer("POINT:FRAMES", 65535); }), warnings)->frames,
            frames);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("the file's size shows 70000"), std::string::npos) << warnings[0];
  EXPECT_EQ(layout_of(with([](C3dWriter& w) { w.integer("POINT:FRAMES", 40000); }), warnings)->frames, 40000);
}

TEST(C3dLayout, RefusesCountsThatDoNotFit) {
  const auto refusal = [](const C3dWriter& writer, std::size_t cut = 0) {
    std::vector<std::string> warnings;
    const auto layout = layout_of(writer, warnings, cut);
    return layout ? std::string("read") : layout.error().message();
  };
  EXPECT_NE(refusal(small_file(), 600).find("a.c3d: has"), std::string::npos);
  EXPECT_NE(refusal(small_file(), 600).find("too few for 20 frames of 2 points and 3 x 4 analog samples"),
            std::string::npos);

  C3dWriter writer = small_file();
  writer.remove("POINT", "FRAMES");
  writer.real_number("POINT:FRAMES", 3e38);
  writer.header_frames = 60000;
  EXPECT_NE(refusal(writer).find("it is cut short or damaged"), std::string::npos);

  writer = small_file();
  writer.frames.assign(20, {});
  writer.channels = 0;
  writer.remove("POINT", "USED"), writer.remove("ANALOG", "USED");
  EXPECT_EQ(refusal(writer), "a.c3d: contains neither points nor analog channels");

  writer = small_file();
  writer.rate = 0;
  writer.remove("POINT", "RATE"), writer.remove("ANALOG", "RATE");
  EXPECT_EQ(refusal(writer), "a.c3d: has no frame rate in POINT:RATE nor in its header");

  writer = small_file(false);
  writer.header_scale = 0;
  writer.remove("POINT", "SCALE");
  EXPECT_EQ(refusal(writer), "a.c3d: has no scale in POINT:SCALE");

  writer = small_file();
  writer.remove("POINT", "FRAMES");
  writer.integer("POINT:FRAMES", 0);
  writer.header_frames = 0;
  EXPECT_EQ(refusal(writer), "a.c3d: holds no frames");
}

}  // namespace
}  // namespace borelli::test::c3d_layout_test
