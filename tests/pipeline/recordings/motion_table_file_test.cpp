// OpenSim's tables against numbers that Python with NumPy read from the same files, and hand-written files in
// OpenSim's and SIMM's layouts.
#include "pipeline/recordings/motion_table_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/paths.hpp"

namespace borelli::test::motion_table_file_test {
namespace {

MotionTable table_in(const std::string& text, const std::string& file = "a.sto") {
  const auto read = parse_motion_table(text, file);
  EXPECT_TRUE(read) << (read ? "" : read.error().message());
  return read ? read->table : MotionTable{};
}

std::string table_error(const std::string& text, const std::string& file = "a.mot") {
  const auto read = parse_motion_table(text, file);
  return read ? "no error" : read.error().message();
}

std::string gait(const std::string& name) { return test::shared_folder() + "/motion/gait10dof/" + name; }

TEST(MotionTableFile, OpenSimsResultsMatchAnotherReader) {
  if (!std::filesystem::exists(gait("subject01_walk_IK.mot"))) GTEST_SKIP() << "no shared files";
  const auto angles = read_motion_table(gait("subject01_walk_IK.mot"));
  ASSERT_TRUE(angles) << angles.error().message();
  EXPECT_TRUE(angles->warnings.empty());
  EXPECT_EQ(angles->table.name, "Coordinates");
  EXPECT_TRUE(angles->table.in_degrees);
  ASSERT_EQ(angles->table.values.rows(), 151);
  ASSERT_EQ(angles->table.columns.size(), 10U);
  EXPECT_EQ(angles->table.columns[9], "lumbar_extension");
  EXPECT_EQ(angles->table.values(150, 9), -15.92098183);
  double sum = angles->table.values.sum();
  for (const double t : angles->table.times) sum += t;
  EXPECT_NEAR(sum, -7440.10912491, 1e-9);  // rounding of 1661 terms

  const auto forces = read_motion_table(gait("subject01_walk_grf.mot"));
  ASSERT_TRUE(forces) << forces.error().message();
  EXPECT_TRUE(forces->warnings.empty());
  EXPECT_EQ(forces->table.name, "subject01_walk1_grf.mot");
  ASSERT_EQ(forces->table.values.rows(), 1501);
  ASSERT_EQ(forces->table.values.cols(), 18);
  sum = forces->table.values.sum();
  for (const double t : forces->table.times) sum += t;
  EXPECT_NEAR(sum, 1090364.12858772, 1e-6);  // rounding of 28519 terms
  EXPECT_EQ(forces->table.values(750, 6), 6.25807536);

  const auto moments = read_motion_table(gait("subject01_walk_ID.sto"));
  ASSERT_TRUE(moments) << moments.error().message();
  EXPECT_FALSE(moments->table.in_degrees);
  EXPECT_EQ(moments->table.name, "Inverse Dynamics Generalized Forces");
  EXPECT_EQ(moments->table.times.front(), -0.0000005);
}

TEST(MotionTableFile, EveryNumberRoundTrips) {
  MotionTable table;
  table.name = "nRows=3";  // a title that looks like a key
  table.columns = {"a", "/jointset/hip/angle/value"};
  table.times = {0.1, 0.1 + 0x1p-50, 1. / 3};
  table.values.resize(3, 2);
  table.values << 1. / 3, std::nan(""), 1e-308, -1.7976931348623157e308, -0., 5e-324;
  table.in_degrees = true;
  const auto text = motion_table_text(table, "out.mot");
  ASSERT_TRUE(text) << text.error().message();
  const MotionTable again = table_in(*text, "out.mot");
  EXPECT_EQ(again.name, table.name);
  EXPECT_EQ(again.columns, table.columns);
  EXPECT_EQ(again.times, table.times);
  EXPECT_EQ(again.in_degrees, table.in_degrees);
  for (int i = 0; i < 6; ++i)
    if (i != 1) {
      EXPECT_EQ(again.values(i / 2, i % 2), table.values(i / 2, i % 2)) << i;
    }
  EXPECT_TRUE(std::isnan(again.values(0, 1)));
  EXPECT_EQ(motion_table_text(again, "out.mot").value(), *text);
}

// A title at the start of a file must not begin with a byte-order mark, which readers drop.
TEST(MotionTableFile, TitleLosesByteOrderMarks) {
  const MotionTable table = table_in("\x05\xEF\xBB\xBF gait\nrange 0 1\nendheader\ntime hip\n0 1\n", "a.mot");
  EXPECT_EQ(table.name, "gait");
  const auto text = motion_table_text(table, "a.mot");
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_EQ(table_in(*text, "a.mot").name, "gait");
}

TEST(MotionTableFile, WritesOpenSimsHeader) {
  MotionTable table;
  table.name = "Coordinates", table.columns = {"hip"}, table.times = {0, 0.5}, table.in_degrees = true;
  table.values = Eigen::MatrixXd::Ones(2, 1);
  EXPECT_EQ(
      motion_table_text(table, "out.mot").value(),
      "Coordinates\nversion=1\nnRows=2\nnColumns=2\ninDegrees=yes\n\nUnits are S.I. units (second, meters, "
      "Newtons, ...)\nAngles are in degrees.\n\nendheader\ntime\thip\n0\t1\n0.5\t1\n");
}

TEST(MotionTableFile, ReadsFilesOfSimm) {
  const std::string body = "endheader\n time\t hip\n 0.0\t 10\n 0.1\t 20\n";
  const MotionTable old = table_in("name walk 1\ndatacolumns 2\ndatarows 2\nrange 0.0 0.1\n" + body, "a.mot");
  EXPECT_EQ(old.name, "walk 1");
  EXPECT_TRUE(old.in_degrees);  // SIMM's convention
  EXPECT_EQ(old.columns, std::vector<std::string>{"hip"});
  EXPECT_EQ(old.values(1, 0), 20);
  EXPECT_FALSE(table_in("name walk\nAngles are in radians.\n" + body, "a.mot").in_degrees);
  EXPECT_FALSE(table_in("name walk\nversion=1\n" + body, "a.mot").in_degrees);
  EXPECT_FALSE(table_in("name walk\n" + body, "a.sto").in_degrees);
  // without a time column the rows are spaced over the range
  const MotionTable spaced =
      table_in("name w\ndatacolumns 1\ndatarows 3\nrange 1.0 2.0\nendheader\nhip\n1\n2\n3\n", "a.mot");
  EXPECT_EQ(spaced.times, (std::vector<double>{1, 1.5, 2}));
}

TEST(MotionTableFile, TabsBlanksAndLineEndsDoNotMatter) {
  for (const std::string text :
       {"t\nversion=1\nendheader\ntime\ta\tb\n0\t1\t2\n1\tnan\t4\n",
        "t\r\nversion=1\r\nendheader\r\ntime\ta\tb\r\n0\t1\t2\r\n1\tnan\t4\r\n",
        "t\nendheader\n\ntime  a b\n 0   1 2\n 1 NaN 4\n\n",
        "t\t\t\nendheader\t\t\ntime\ta\tb\t\n0\t\t1\t2\n1\t-nan(ind)\t4\t\t\n",
        "t\nendheader\ntime\ta\tb\n0\t1\t2\n1\t\t4\n",
        "t\nendheader\n\t\t\n \ntime\ta b\n0.\t1\t2.\n1. nan\t\t4\n",  // OpenSim's testDiff.sto
        "t\nendheader\ntime\ta\t\tb\n0\t1\t2\n1\tnan\t4\n"}) {
    const MotionTable table = table_in(text);
    EXPECT_EQ(table.name, "t") << text;
    EXPECT_EQ(table.columns, (std::vector<std::string>{"a", "b"})) << text;
    ASSERT_EQ(table.values.rows(), 2) << text;
    EXPECT_EQ(table.values(0, 1), 2) << text;
    EXPECT_TRUE(std::isnan(table.values(1, 0))) << text;
    EXPECT_EQ(table.values(1, 1), 4) << text;
  }
  const MotionTable last = table_in("t\nendheader\ntime\ta\tb\n0\t1\t2\n1\t3\t\n");
  EXPECT_TRUE(std::isnan(last.values(1, 1)));
}

TEST(MotionTableFile, RowsOverrideTheHeaderWithAWarning) {
  const auto read = parse_motion_table("t\nnRows=9\nnColumns=5\nendheader\ntime a\n0 1\n1 2\n", "a.sto");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->warnings.size(), 2U);
  EXPECT_EQ(read->warnings[0], "The header announces 5 columns, but 2 are named; those were read.");
  EXPECT_EQ(read->warnings[1], "The header announces 9 rows, but the file contains 2; those were read.");
}

TEST(MotionTableFile, NamesBetweenTabsMayHoldBlanks) {
  const MotionTable table = table_in("t\nendheader\ntime\tvastus lateralis\tb\n0\t1\t2\n");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"vastus lateralis", "b"}));
}

TEST(MotionTableFile, KeepsTheFirstOfRowsAtOneTime) {
  const auto read = parse_motion_table("t\nnRows=4\nendheader\ntime a\n0 1\n1 2\n1 3\n1 4\n", "a.sto");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->table.times, (std::vector<double>{0, 1}));
  EXPECT_EQ(read->table.values(1, 0), 2);
  EXPECT_EQ(read->warnings,
            std::vector<std::string>{"2 rows repeat the time of the row before; the first row of "
                                     "each time was kept."});
}

TEST(MotionTableFile, BadFilesAreRefusedWithTheirLine) {
  EXPECT_EQ(table_error("t\nnRows=1\n"),
            "a.mot: has no line 'endheader'; expected a table as OpenSim writes it (.mot, .sto)");
  EXPECT_EQ(table_error("t\nendheader\n"), "a.mot: ends before its line of column names");
  EXPECT_EQ(table_error("t\nendheader\ntime a a\n0 1 2\n"), "a.mot:3: has two columns 'a'; rename one");
  EXPECT_EQ(table_error("t\nendheader\nt a\n0 1\n"), "a.mot:3: has 't' as its first column, expected 'time'");
  EXPECT_EQ(table_error("t\nendheader\ntime a b\n0 1\n"),
            "a.mot:4: has 2 numbers, expected 3: one per column");
  EXPECT_EQ(table_error("t\nendheader\ntime a\n0 one\n"),
            "a.mot:4: a is 'one', expected a number with a decimal point, or nan");
  EXPECT_EQ(table_error("t\nendheader\ntime a\nnan 1\n"),
            "a.mot:4: time is 'nan', expected a number with a decimal point");
  EXPECT_EQ(table_error("t\nendheader\ntime a\n0 1\n-1 1\n"),
            "a.mot:5: has the time -1 s, expected more than the 0 s of the row before");
  EXPECT_EQ(table_error("t\nendheader\ntime a\n"), "a.mot: contains no row below its column names");
  EXPECT_EQ(table_error("t\nnRows=-1\nendheader\n"), "a.mot:2: says nrows is '-1', expected a count");
  EXPECT_EQ(table_error("t\ninDegrees=maybe\nendheader\n"),
            "a.mot:2: says inDegrees=maybe, expected yes or no");
  EXPECT_EQ(table_error("t\nDataType=Vec3\nendheader\n"),
            "a.mot:2: says DataType=Vec3, expected a table of plain numbers (double)");
}

TEST(MotionTableFile, RefusesToWriteATableThatOpenSimWouldMisread) {
  MotionTable table;
  table.columns = {"a b"}, table.times = {0}, table.values = Eigen::MatrixXd::Zero(1, 1);
  EXPECT_FALSE(motion_table_text(table, "out.mot"));
  table.columns = {"a"};
  EXPECT_TRUE(motion_table_text(table, "out.mot"));
  table.values(0, 0) = INFINITY;
  EXPECT_FALSE(motion_table_text(table, "out.mot"));
  table.values = Eigen::MatrixXd::Zero(2, 1);
  EXPECT_FALSE(motion_table_text(table, "out.mot"));
}

}  // namespace
}  // namespace borelli::test::motion_table_file_test
