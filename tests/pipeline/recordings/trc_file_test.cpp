// TRC files against numbers that Python with NumPy read from the same files, and hand-written files in the
// layouts of OpenSim's test files.
#include "pipeline/recordings/trc_file.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <filesystem>

#include "tests/paths.hpp"

namespace borelli::test::trc_file_test {
namespace {

const std::string trc_head =
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100.00\t50.00\t2\t2\tmm\t100.00\t1\t2\n"
    "Frame#\tTime\tLASI\t\t\tRASI\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == text.npos ? "no '" + from + "' to replace" : text.replace(at, from.size(), to);
}

MarkerMotion trc_motion(const std::string& text) {
  const auto trc = parse_trc(text, "a.trc");
  EXPECT_TRUE(trc) << (trc ? "" : trc.error().message());
  return trc ? trc->motion : MarkerMotion{};
}

std::string trc_error(const std::string& text) {
  const auto trc = parse_trc(text, "a.trc");
  return trc ? "no error" : trc.error().message();
}

const std::string two_rows = "1\t0.00\t1\t2\t3\t4\t5\t6\n2\t0.01\t7\t8\t9\t10\t11\t12.5\n";

TEST(TrcFile, WalkMatchesAnotherReader) {
  const std::string file = test::shared_folder() + "/motion/gait10dof/subject01_walk.trc";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const auto trc = read_trc(file);
  ASSERT_TRUE(trc) << trc.error().message();
  EXPECT_TRUE(trc->warnings.empty());
  EXPECT_EQ(trc->data_rate, 60);
  EXPECT_EQ(trc->unit, "mm");
  const MarkerMotion& motion = trc->motion;
  ASSERT_EQ(motion.names.size(), 41U);
  EXPECT_EQ(motion.names.front(), "R.ASIS");
  EXPECT_EQ(motion.names.back(), "Top.Head");
  ASSERT_EQ(motion.frames.size(), 151U);
  EXPECT_EQ(motion.times.back(), 2.5);
  double sum = 0;
  for (const auto& frame : motion.frames) sum += frame.sum();
  EXPECT_NEAR(sum, 8171.94405727, 1e-9);  // rounding of 18573 terms
  const auto heel = std::find(motion.names.begin(), motion.names.end(), "R.Heel") - motion.names.begin();
  EXPECT_EQ(motion.frames.back().col(heel), Eigen::Vector3d(0.11298324, 0.11430198, 0.09124348));
  EXPECT_FALSE(motion.up);
}

TEST(TrcFile, AFileReadWrittenAndReadIsTheSameToTheLastBit) {
  for (const std::string name : {"subject01_walk.trc", "subject01_static.trc"}) {
    const std::string file = test::shared_folder() + "/motion/gait10dof/" + name;
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const auto trc = read_trc(file);
    ASSERT_TRUE(trc) << trc.error().message();
    const auto text = trc_text(*trc, file);
    ASSERT_TRUE(text) << text.error().message();
    const auto again = parse_trc(*text, file);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(again->motion.names, trc->motion.names);
    EXPECT_EQ(again->motion.times, trc->motion.times);
    EXPECT_EQ(again->motion.frames, trc->motion.frames);
    EXPECT_EQ(trc_text(*again, file).value(), *text);
  }
}

TEST(TrcFile, RateIsThatOfTheUsualInterval) {
  TrcFile trc;
  trc.motion.names = {"A"};
  for (const double t : {0., 0.3, 0.6, 1.5, 1.8, 1.9})  // a gap, and a short last interval
    trc.motion.times.push_back(t), trc.motion.frames.push_back(Eigen::Matrix3Xd::Zero(3, 1));
  const auto read = parse_trc(trc_text(trc, "a.trc").value(), "a.trc");
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->data_rate, 1 / 0.3, 1e-6);
  trc.motion.times.clear(), trc.motion.frames.clear();
  for (int i = 0; i <= 120; ++i)  // 120 Hz, in whole milliseconds
    trc.motion.times.push_back(1e-3 * std::round(1000. * i / 120)),
        trc.motion.frames.push_back(Eigen::Matrix3Xd::Zero(3, 1));
  EXPECT_NEAR(parse_trc(trc_text(trc, "a.trc").value(), "a.trc").value().data_rate, 120, 1e-6);
}

TEST(TrcFile, EveryUnitIsReadAsMetres) {
  for (const auto& [unit, x] : {std::pair{"mm", 0.001},
                                {"cm", 0.01},
                                {"m", 1.},
                                {"Meters", 1.},
                                {"MM", 0.001},
                                {"centimeters", 0.01},
                                {"in", 0.0254},
                                {"ft", 0.3048}}) {
    const auto motion = trc_motion(replaced(trc_head, "\tmm\t", std::string("\t") + unit + "\t") + two_rows);
    ASSERT_EQ(motion.frames.size(), 2U) << unit;
    EXPECT_DOUBLE_EQ(motion.frames[0](0, 0), x) << unit;
  }
  EXPECT_EQ(trc_error(replaced(trc_head, "\tmm\t", "\tparsec\t") + two_rows),
            "a.trc:3: Units is 'parsec', expected m, dm, cm, mm, um, in or ft");
}

TEST(TrcFile, GapsAreNotZeros) {
  const auto motion = trc_motion(trc_head +
                                 "1\t0.00\t\t\t\t4\t5\t6\n"             // empty cells
                                 "2\t0.01\t NaN\tnan\t-nan\t4\t5\t6\n"  // words, with blanks
                                 "3\t0.02\t1\t2\t3\n"                   // a row that ends early
                                 "4\t0.03\n"                            // without any marker
                                 "5\t0.04\t1\t2\t\t4\t5\t6\t\t\n");  // a missing coordinate; tabs at the end
  ASSERT_EQ(motion.frames.size(), 5U);
  const auto seen = [&](int frame, int marker) { return motion.frames[frame].col(marker).allFinite(); };
  const auto gap = [&](int frame, int marker) {
    return motion.frames[frame].col(marker).array().isNaN().all();
  };
  EXPECT_TRUE(gap(0, 0) && seen(0, 1));
  EXPECT_TRUE(gap(1, 0) && seen(1, 1));
  EXPECT_TRUE(seen(2, 0) && gap(2, 1));
  EXPECT_TRUE(gap(3, 0) && gap(3, 1));
  EXPECT_TRUE(gap(4, 0) && seen(4, 1));
  const auto trc = parse_trc(trc_head + "1\t0\t1\t2\t\t4\t5\t6\n", "a.trc");
  ASSERT_TRUE(trc);
  ASSERT_EQ(trc->warnings.size(), 2U);
  EXPECT_NE(trc->warnings[1].find("lacks one or two of its coordinates 1 times"), std::string::npos);
}

TEST(TrcFile, GapsAreWrittenAndReadBackAsGaps) {
  TrcFile trc;
  trc.motion.names = {"A", "B"};
  trc.motion.times = {0, 0.1};
  trc.motion.frames.assign(2, Eigen::Matrix3Xd::Constant(3, 2, 0.1));
  trc.motion.frames[1].col(0).setConstant(std::nan(""));
  const auto text = trc_text(trc, "out.trc");
  ASSERT_TRUE(text);
  const auto motion = trc_motion(*text);
  EXPECT_TRUE(motion.frames[1].col(0).array().isNaN().all());
  EXPECT_EQ(motion.frames[1].col(1), Eigen::Vector3d::Constant(0.1));
  EXPECT_NE(text->find("\n10\t10\t2\t2\tmm\t10\t1\t2\n"), std::string::npos) << *text;  // rate of the times
}

TEST(TrcFile, LayoutsOfOtherProgramsAreRead) {
  const auto plain = trc_motion(trc_head + "\n" + two_rows);
  std::string windows;
  for (const char c : trc_head + "\n" + two_rows) windows += c == '\n' ? "\r\n" : std::string(1, c);
  const std::string shifted =  // a tab before the names, two after each: OpenSim's std_walking2_markers.trc
      replaced(replaced(trc_head, "Time\tLASI\t\t\tRASI\t\t", "Time\t\tLASI\t\tRASI\t\t"), "\t\tX1",
               "\t\t\tX1");
  const std::string many_tabs =
      replaced(trc_head, "100.00\t50.00\t2\t2\tmm\t", "  100.0\t\t  50.0\t\t   2\t\t  2\t\t mm\t");
  const std::string blanks =
      "PathFileType  4 (X/Y/Z) a\nDataRate CameraRate NumFrames NumMarkers Units\n100 50 2 2 mm\n"
      "Frame# Time LASI RASI\n X1 Y1 Z1 X2 Y2 Z2\n1 0.00 1 2 3 4 5 6\n2 0.01 7 8 9 10 11 12.5";
  for (const std::string& text :
       {trc_head + two_rows, replaced(trc_head, "\t50.00\t", "\t\t") + two_rows,
        replaced(trc_head, "100.00\t50.00\t2\t2\tmm\t100.00\t1\t2", "100.00\t\t50.00\t2\t2\tmm") + two_rows,
        windows, "\xef\xbb\xbf" + trc_head + two_rows, shifted + two_rows, many_tabs + two_rows, blanks,
        trc_head + "\t\t\t\t\t\t\t\t\n" + two_rows + "\n\n"}) {
    const auto motion = trc_motion(text);
    EXPECT_EQ(motion.names, plain.names) << text;
    EXPECT_EQ(motion.times, plain.times) << text;
    EXPECT_EQ(motion.frames, plain.frames) << text;
  }
  EXPECT_EQ(plain.frames[1].col(1), Eigen::Vector3d(0.01, 0.011, 0.0125));
}

TEST(TrcFile, RowsOverrideTheHeaderWithAWarning) {
  const auto trc = parse_trc(replaced(trc_head, "\t2\t2\tmm", "\t7\t3\tmm") + two_rows, "a.trc");
  ASSERT_TRUE(trc) << trc.error().message();
  EXPECT_EQ(trc->motion.frames.size(), 2U);
  ASSERT_EQ(trc->warnings.size(), 2U);
  EXPECT_EQ(trc->warnings[0], "The header announces 3 markers, but 2 are named; those were read.");
  EXPECT_EQ(trc->warnings[1], "The header announces 7 frames, but the file contains 2; those were read.");
  EXPECT_EQ(trc_error(replaced(trc_head, "\t\t\tRASI", "\t\t\tRASI\t\t\tSACR") + two_rows),
            "a.trc:5: has 6 coordinate labels, expected 9: three for each of the 3 names in line 4");
}

TEST(TrcFile, BadFilesAreRefusedWithTheirLine) {
  EXPECT_EQ(trc_error(""), "a.trc:0: does not begin with 'PathFileType', expected a TRC file");
  EXPECT_EQ(trc_error(trc_head), "a.trc: holds no frame after its header");
  EXPECT_EQ(trc_error(trc_head + "1\t0.1\n2\t0.1\n"),
            "a.trc:7: has the time 0.1 s, expected more than the 0.1 s of the row before");
  EXPECT_EQ(trc_error(trc_head + "1\t0\t1\t2\t3,5\n"),
            "a.trc:6: Z of marker 'LASI' is '3,5', expected a number with a decimal point, or nothing");
  EXPECT_EQ(trc_error(trc_head + "1\t0\t1\t2\tinf\n"),
            "a.trc:6: Z of marker 'LASI' is 'inf', expected a number with a decimal point, or nothing");
  EXPECT_EQ(trc_error(trc_head + "1\t0\t1\t2\t3\t4\t5\t6\t7\n"),
            "a.trc:6: has 9 cells, expected at most 8 for 2 markers");
  EXPECT_EQ(trc_error(trc_head + "one\t0\t1\n"), "a.trc:6: begins with 'one', expected a frame number");
  EXPECT_EQ(trc_error(trc_head + "1\tnan\t1\n"), "a.trc:6: has the time 'nan', expected a number of seconds");
  EXPECT_EQ(trc_error(replaced(trc_head, "RASI", "LASI") + two_rows),
            "a.trc:4: names the marker 'LASI' twice");
  EXPECT_EQ(read_trc("/dev/zero").error().message(),
            "/dev/zero: is not a regular file but a pipe or a device");
}

TEST(TrcFile, ShortRowsCannotAskForMuchMemory) {
  std::string text = replaced(trc_head, "Frame#\tTime\tLASI\t\t\tRASI\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n", "");
  text += "Frame#\tTime";
  std::string labels = "\t";
  for (int i = 1; i <= 5000; ++i) {
    text += "\tm" + std::to_string(i);
    labels += "\tX\tY\tZ";
  }
  text += "\n" + labels + "\n";
  for (int i = 0; i < 50000; ++i) text += std::to_string(i) + "\t" + std::to_string(i) + "\n";
  EXPECT_NE(trc_error(text).find("expected rows that do not end so early"), std::string::npos);
}

TEST(TrcFile, ALocaleWithCommasChangesNothing) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"})
    if (std::setlocale(LC_NUMERIC, name)) break;
  EXPECT_EQ(trc_motion(trc_head + two_rows).frames[1](2, 1), 0.0125);
  std::setlocale(LC_NUMERIC, before.c_str());
}

TEST(TrcFile, RefusesToWriteAnInconsistentMotion) {
  TrcFile trc;
  trc.motion.names = {"A\tB"};
  trc.motion.times = {0};
  trc.motion.frames = {Eigen::Matrix3Xd::Zero(3, 1)};
  EXPECT_FALSE(trc_text(trc, "out.trc"));
  trc.motion.names = {"A"};
  EXPECT_TRUE(trc_text(trc, "out.trc"));
  trc.unit = "furlong";
  EXPECT_FALSE(trc_text(trc, "out.trc"));
  trc.unit = "m", trc.motion.times = {0, 1};
  EXPECT_FALSE(trc_text(trc, "out.trc"));
}

}  // namespace
}  // namespace borelli::test::trc_file_test
