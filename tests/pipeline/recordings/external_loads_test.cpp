// External loads: OpenSim's example of a walk, and hand-written files after the description of OpenSim's
// ExternalForce.
#include "pipeline/recordings/external_loads.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "pipeline/recordings/motion_table_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::test::external_loads_test {
namespace {

const std::string grf_table =
    "grf\nversion=1\nendheader\ntime\tf_vx\tf_vy\tf_vz\tf_px\tf_py\tf_pz\tm1\tm2\tm3\tap\tbz\tcy\n"
    "0\t1\t2\t3\t4\t5\t6\t7\t8\t9\t10\t11\t12\n0.1\t10\t20\t30\t40\t50\t60\t70\t80\t90\t100\t110\t120\n";

std::string force_xml(const std::string& properties) {
  return "<ExternalForce name=\"right\"><applied_to_body> calcn_r </applied_to_body>" + properties +
         "</ExternalForce>";
}
std::string loads_xml(const std::string& forces, const std::string& version = "30000") {
  return "<?xml version=\"1.0\"?><OpenSimDocument Version=\"" + version +
         "\"><ExternalLoads name=\"walk\"><objects>" + forces +
         "</objects><groups/><datafile>grf.mot</datafile></ExternalLoads></OpenSimDocument>";
}

Result<ExternalLoads> loads_in(const TestFolder& folder, const std::string& xml) {
  folder.write("grf.mot", grf_table);
  return read_external_loads(folder.write("loads.xml", xml));
}

std::string loads_error(const std::string& xml) {
  const TestFolder folder;
  const auto loads = loads_in(folder, xml);
  return loads ? "no error" : loads.error().what;
}

const std::string force_and_point =
    "<force_identifier>f_v</force_identifier><point_identifier>f_p</point_identifier>";

TEST(ExternalLoads, WalkHasTheColumnsOfItsTable) {
  const std::string folder = test::shared_folder() + "/motion/gait10dof/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto loads = read_external_loads(folder + "subject01_walk_grf.xml");
  ASSERT_TRUE(loads) << loads.error().message();
  EXPECT_EQ(loads->name, "WalkingGRF");
  EXPECT_TRUE(loads->not_modelled.empty());
  EXPECT_TRUE(loads->warnings.empty());
  EXPECT_TRUE(loads->disabled.empty());
  ASSERT_EQ(loads->loads.size(), 2U);
  const ExternalLoad &right = loads->loads[0], &left = loads->loads[1];
  EXPECT_EQ(right.body, "calcn_r");
  EXPECT_EQ(left.body, "calcn_l");
  EXPECT_EQ(left.measured.name, "left");
  EXPECT_EQ(right.force_body, "ground");
  EXPECT_EQ(right.point_body, "ground");
  ASSERT_EQ(right.measured.times.size(), 1501U);
  // the table's first row in the file
  EXPECT_EQ(right.measured.force.col(0), Eigen::Vector3d(101.5119767, 745.4661142, -47.44870554));
  EXPECT_EQ(right.measured.point.col(0), Eigen::Vector3d(0.37898285, -0.0075, 0.12774652));
  EXPECT_EQ(left.measured.force.col(0), Eigen::Vector3d(17.26938127, 20.49185173, -7.46930128));
  EXPECT_EQ(right.measured.moment.col(0), Eigen::Vector3d(0, 13.53783445, 0));
  EXPECT_EQ(left.measured.moment.col(0), Eigen::Vector3d(1.5550397, -0.75741936, 6.88030347));
}

TEST(ExternalLoads, TheRootMayBeTheLoadsThemselves) {
  const TestFolder folder;
  const auto loads = loads_in(folder, "<ExternalLoads><objects>" + force_xml(force_and_point) +
                                          "</objects><datafile>grf.mot</datafile></ExternalLoads>");
  ASSERT_TRUE(loads) << loads.error().message();
  EXPECT_EQ(loads->loads[0].body, "calcn_r");
  EXPECT_EQ(loads->loads[0].measured.force.col(1), Eigen::Vector3d(10, 20, 30));
  EXPECT_EQ(loads->loads[0].measured.moment, (Eigen::Matrix3Xd::Zero(3, 2)));
}

TEST(ExternalLoads, PathsAreReducedToNames) {
  const TestFolder folder;
  const auto loads = loads_in(
      folder, loads_xml("<ExternalForce name=\"a\"><applied_to_body>/bodyset/calcn_l</applied_to_body>"
                        "<force_expressed_in_body>/bodyset/tibia_l</force_expressed_in_body>"
                        "<point_expressed_in_body>/bodyset/calcn_l</point_expressed_in_body>" +
                            force_and_point + "<torque_identifier>m</torque_identifier></ExternalForce>",
                        "40000"));
  ASSERT_TRUE(loads) << loads.error().message();
  EXPECT_EQ(loads->loads[0].body, "calcn_l");
  EXPECT_EQ(loads->loads[0].force_body, "tibia_l");
  EXPECT_EQ(loads->loads[0].point_body, "calcn_l");
  EXPECT_EQ(loads->loads[0].measured.moment.col(0), Eigen::Vector3d(7, 8, 9));  // endings 1, 2, 3
}

TEST(ExternalLoads, AForceWithoutAPointActsAtTheBodysOrigin) {
  const TestFolder folder;
  const auto loads = loads_in(folder, loads_xml(force_xml("<force_identifier>f_v</force_identifier>")));
  ASSERT_TRUE(loads) << loads.error().message();
  EXPECT_EQ(loads->loads[0].point_body, "calcn_r");
  EXPECT_EQ(loads->loads[0].measured.point, (Eigen::Matrix3Xd::Zero(3, 2)));
  EXPECT_EQ(loads->loads[0].force_body, "ground");
}

TEST(ExternalLoads, DisabledLoadsAreListedSeparately) {
  for (const std::string off : {"<isDisabled> true </isDisabled>", "<appliesForce>false</appliesForce>"}) {
    const TestFolder folder;
    const auto loads = loads_in(folder, loads_xml(force_xml(off + force_and_point)));
    ASSERT_TRUE(loads) << loads.error().message();
    EXPECT_TRUE(loads->loads.empty());
    EXPECT_EQ(loads->disabled, std::vector<std::string>{"right"});
  }
  EXPECT_EQ(loads_error(loads_xml(force_xml("<isDisabled>perhaps</isDisabled>" + force_and_point))),
            "isDisabled: is 'perhaps', expected true or false");
}

TEST(ExternalLoads, IdentifiersFindThreeColumnsInTheOrderOfTheirEndings) {
  MotionTable table;
  table.columns = {"f2",  "f1",  "f3", "g.z", "g.x", "g.y", "g_sum", "hap",
                   "hml", "hup", "ix", "iy",  "kX",  "kY",  "kZ",    "kxx"};
  const auto columns = [&](const std::string& identifier) {
    const auto found = identified_columns(table, identifier, "a.xml:1");
    return found ? std::vector<Eigen::Index>(found->column, found->column + 3) : std::vector<Eigen::Index>{};
  };
  using Indices = std::vector<Eigen::Index>;
  EXPECT_EQ(columns("f"), (Indices{1, 0, 2}));
  EXPECT_EQ(columns("g"), (Indices{4, 5, 3}));  // four columns begin so; three have an axis after a dot
  EXPECT_EQ(columns("g."), (Indices{4, 5, 3}));
  EXPECT_EQ(columns("h"), (Indices{7, 8, 9}));  // in the file's order
  EXPECT_FALSE(identified_columns(table, "h", "")->in_order);
  EXPECT_EQ(columns("k"), (Indices{12, 13, 14}));
  EXPECT_EQ(identified_columns(table, "i", "a.xml:1").error().message(),
            "a.xml:1: the identifier 'i' fits 2 columns of the table (ix, iy), expected three");
  EXPECT_EQ(identified_columns(table, "q", "a.xml:1").error().message(),
            "a.xml:1: the identifier 'q' fits 0 columns of the table, expected three");
}

TEST(ExternalLoads, ListsWhatIsNotRead) {
  const TestFolder folder;
  const auto loads = loads_in(folder, loads_xml(force_xml(force_and_point + "<gain>2</gain><note/>")));
  ASSERT_TRUE(loads) << loads.error().message();
  ASSERT_EQ(loads->not_modelled.motion.size(), 1U);
  EXPECT_NE(loads->not_modelled.motion[0].find("<gain> in <ExternalForce>"), std::string::npos);
  EXPECT_TRUE(loads->not_modelled.other.empty());
}

TEST(ExternalLoads, BadFilesAreRefused) {
  EXPECT_EQ(loads_error("<Model/>"),
            "Model: is not a <ExternalLoads>; expected that, or an <OpenSimDocument> that contains it");
  EXPECT_EQ(loads_error("<OpenSimDocument><Model/></OpenSimDocument>"),
            "OpenSimDocument: holds <Model>, expected a <ExternalLoads>");
  EXPECT_EQ(loads_error("<ExternalLoads/>"), "ExternalLoads: has no datafile; name the table of its forces");
  EXPECT_EQ(
      loads_error(loads_xml(force_xml(""))),
      "ExternalForce 'right': has neither a force_identifier nor a torque_identifier; give at least one");
  EXPECT_EQ(loads_error(loads_xml("<ExternalForce>" + force_and_point + "</ExternalForce>")),
            "ExternalForce: has no applied_to_body; name the body that it acts on");
  EXPECT_NE(loads_error(loads_xml("<PrescribedForce/>")).find("before 2.3.1"), std::string::npos);
  EXPECT_NE(loads_error(loads_xml("")).find("contains no <ExternalForce>"), std::string::npos);
  const TestFolder folder;
  const auto loads = read_external_loads(folder.write("loads.xml", loads_xml(force_xml(force_and_point))));
  ASSERT_FALSE(loads);
  EXPECT_EQ(loads.error().what,
            "its table cannot be read: " + (folder / "grf.mot").string() + ": no such file");
}

}  // namespace
}  // namespace borelli::test::external_loads_test
