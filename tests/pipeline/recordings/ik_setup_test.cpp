// Set-ups of OpenSim's inverse kinematics and inverse dynamics: its own example and hand-written files.
#include "pipeline/recordings/ik_setup.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "pipeline/recordings/id_setup.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::test::ik_setup_test {
namespace {

constexpr double infinite_time = std::numeric_limits<double>::infinity();

std::string ik_error(const std::string& inside) {
  const TestFolder folder;
  const auto setup =
      read_ik_setup(folder.write("ik.xml", "<InverseKinematicsTool>" + inside + "</InverseKinematicsTool>"));
  return setup ? "no error" : setup.error().what;
}

std::string id_error(const std::string& inside) {
  const TestFolder folder;
  const auto setup =
      read_id_setup(folder.write("id.xml", "<InverseDynamicsTool>" + inside + "</InverseDynamicsTool>"));
  return setup ? "no error" : setup.error().what;
}

TEST(InverseKinematicsSetup, TheSetupOfAWalkIsReadWhole) {
  const std::filesystem::path folder = test::shared_folder() + "/motion/gait10dof";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto setup = read_ik_setup(folder / "walk_Setup_IK.xml");
  ASSERT_TRUE(setup) << setup.error().message();
  EXPECT_TRUE(setup->not_modelled.empty());
  EXPECT_EQ(setup->marker_file.lexically_relative(folder.lexically_normal()),
            "../ExperimentalData/subject01_walk.trc");
  EXPECT_EQ(setup->model_file.filename(), "subject01.osim");
  EXPECT_TRUE(setup->coordinate_file.empty());  // "Unassigned"
  EXPECT_EQ(setup->constraint_weight, infinite_time);
  EXPECT_EQ(setup->accuracy, 1e-5);
  EXPECT_EQ(setup->time_range, std::pair(0., 2.5));
  EXPECT_TRUE(setup->report_errors);
  EXPECT_FALSE(setup->report_marker_locations);
  EXPECT_TRUE(setup->coordinates.empty());
  // counted in the file with Python's ElementTree: 39 tasks, 31 applied, sum of weights 51
  EXPECT_EQ(setup->markers.front().marker, "Sternum");
  double weights = 0;
  int applied = 0;
  for (const MarkerTask& task : setup->markers) weights += task.weight, applied += task.apply;
  EXPECT_EQ(setup->markers.size(), 39U);
  EXPECT_EQ(applied, 31);
  EXPECT_EQ(weights, 51);
}

TEST(InverseKinematicsSetup, DefaultsMatchOpenSim) {
  const TestFolder folder;
  const auto setup = read_ik_setup(
      folder.write("ik.xml",
                   "<OpenSimDocument Version=\"40000\"><InverseKinematicsTool name=\"t\"><IKTaskSet><objects>"
                   "<IKMarkerTask name=\"a\"/><IKCoordinateTask name=\"hip\"/>"
                   "</objects></IKTaskSet></InverseKinematicsTool></OpenSimDocument>"));
  ASSERT_TRUE(setup) << setup.error().message();
  ASSERT_EQ(setup->markers.size(), 1U);
  EXPECT_TRUE(setup->markers[0].apply);
  EXPECT_EQ(setup->markers[0].weight, 0);
  ASSERT_EQ(setup->coordinates.size(), 1U);
  EXPECT_EQ(setup->coordinates[0].target, CoordinateTask::Target::default_value);
  EXPECT_EQ(setup->constraint_weight, infinite_time);
  EXPECT_EQ(setup->accuracy, 1e-5);
  EXPECT_EQ(setup->time_range, std::pair(-infinite_time, infinite_time));
  EXPECT_TRUE(setup->report_errors);
  EXPECT_TRUE(setup->marker_file.empty());
}

TEST(InverseKinematicsSetup, CoordinateTasksAndOlderNamesAreRead) {
  const TestFolder folder;
  const auto setup = read_ik_setup(folder.write(
      "ik.xml",
      "<IKTool name=\"old\"><IKTaskSet>\n"
      "<IKCoordinateTask name=\"/jointset/hip_r/hip_flexion_r\"><apply> false </apply><weight> 1000.0 "
      "</weight>"
      "<value_type> Manual_Value </value_type><value> -0.25 </value></IKCoordinateTask>\n"
      "<IKCoordinateTask "
      "name=\"knee\"><weight>2</weight><value_type>from_file</value_type></IKCoordinateTask>\n"
      "<IKOrientationTask name=\"pelvis\"><weight>1</weight></IKOrientationTask></IKTaskSet>\n"
      "<coordinate_file>..\\data\\a.mot</coordinate_file><constraint_weight>20</constraint_weight>"
      "<time_range>0.5 Inf</time_range><report_errors>False</report_errors></IKTool>"));
  ASSERT_TRUE(setup) << setup.error().message();
  ASSERT_EQ(setup->coordinates.size(), 2U);
  EXPECT_EQ(setup->coordinates[0].coordinate, "hip_flexion_r");
  EXPECT_FALSE(setup->coordinates[0].apply);
  EXPECT_EQ(setup->coordinates[0].weight, 1000);
  EXPECT_EQ(setup->coordinates[0].target, CoordinateTask::Target::manual_value);
  EXPECT_EQ(setup->coordinates[0].value, -0.25);
  EXPECT_EQ(setup->coordinates[1].target, CoordinateTask::Target::from_file);
  EXPECT_EQ(setup->constraint_weight, 20);
  EXPECT_EQ(setup->time_range, std::pair(0.5, infinite_time));
  EXPECT_FALSE(setup->report_errors);
  EXPECT_EQ(setup->coordinate_file, (folder.path().parent_path() / "data" / "a.mot"));
  ASSERT_EQ(setup->not_modelled.motion.size(), 1U);
  EXPECT_NE(setup->not_modelled.motion[0].find("<IKOrientationTask> in <IKTaskSet>"), std::string::npos);
}

TEST(InverseKinematicsSetup, BadFilesAreRefused) {
  const auto task = [](const std::string& inside) {
    return "<IKTaskSet><objects><IKMarkerTask name=\"a\">" + inside + "</IKMarkerTask></objects></IKTaskSet>";
  };
  EXPECT_NE(ik_error(task("<weight>1e308</weight>")).find("expected a number from 0 to 1e+12"),
            std::string::npos);
  EXPECT_EQ(ik_error(task("<weight>-1</weight>")),
            "IKMarkerTask 'a': has the weight -1, expected a number from 0 to 1e+12");
  EXPECT_EQ(ik_error(task("<weight>heavy</weight>")), "weight: is 'heavy', expected a number");
  EXPECT_EQ(ik_error(task("<weight>nan</weight>")), "weight: is 'nan', expected a number");
  EXPECT_EQ(ik_error(task("<weight>1</weight><weight>2</weight>")),
            "weight: IKMarkerTask 'a' has two of these; expected one");
  EXPECT_EQ(ik_error("<IKTaskSet><IKMarkerTask/></IKTaskSet>"),
            "IKMarkerTask: has no name; give it that of a marker");
  EXPECT_EQ(ik_error("<IKTaskSet><IKMarkerTask name=\"a\"/><IKMarkerTask name=\"a\"/></IKTaskSet>"),
            "IKTaskSet: has two tasks for the marker 'a'");
  EXPECT_EQ(ik_error("<time_range>2 1</time_range>"), "time_range: is '2 1', expected its start and its end");
  EXPECT_EQ(ik_error("<accuracy>0</accuracy>"),
            "InverseKinematicsTool: has the accuracy 0, expected a positive number");
  EXPECT_NE(ik_error("<IKTrialSet/>").find("before 2.3"), std::string::npos);
  EXPECT_EQ(ik_error("<marker_file><a/></marker_file>"), "marker_file: holds <a>, expected text");
  EXPECT_EQ(
      ik_error("<IKTaskSet><IKCoordinateTask name=\"c\"><value_type>any</value_type></IKCoordinateTask>"
               "</IKTaskSet>"),
      "IKCoordinateTask 'c': has the value_type 'any', expected default_value, manual_value or from_file");
}

TEST(InverseDynamicsSetup, TheSetupOfAWalkIsReadWhole) {
  const std::filesystem::path folder = test::shared_folder() + "/motion/gait10dof";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto setup = read_id_setup(folder / "walk_Setup_ID.xml");
  ASSERT_TRUE(setup) << setup.error().message();
  EXPECT_TRUE(setup->not_modelled.empty());
  EXPECT_EQ(setup->name, "walk_subject");
  EXPECT_EQ(setup->lowpass_cutoff, 6);
  EXPECT_EQ(setup->time_range, std::pair(0., 2.5));
  EXPECT_EQ(setup->forces_to_exclude, std::vector<std::string>{"Muscles"});
  EXPECT_EQ(setup->external_loads_file.lexically_relative(folder.lexically_normal()),
            "../ExperimentalData/subject01_walk_grf.xml");
  EXPECT_EQ(setup->coordinates_file.filename(), "subject01_walk_IK.mot");
  EXPECT_EQ(setup->output_gen_force_file, "subject01_walk_ID.sto");
}

TEST(InverseDynamicsSetup, ANegativeCutoffIsNoFilterAndTheRestIsListed) {
  const TestFolder folder;
  const auto setup = read_id_setup(
      folder.write("id.xml",
                   "<InverseDynamicsTool><lowpass_cutoff_frequency_for_coordinates>-1"
                   "</lowpass_cutoff_frequency_for_coordinates><joints_to_report_body_forces>All"
                   "</joints_to_report_body_forces><coordinates_in_degrees>true</coordinates_in_degrees>"
                   "<forces_to_exclude> Muscles\n actuators </forces_to_exclude></InverseDynamicsTool>"));
  ASSERT_TRUE(setup) << setup.error().message();
  EXPECT_FALSE(setup->lowpass_cutoff);
  EXPECT_EQ(setup->forces_to_exclude, (std::vector<std::string>{"Muscles", "actuators"}));
  EXPECT_EQ(setup->output_gen_force_file, "inverse_dynamics.sto");
  EXPECT_EQ(setup->not_modelled.motion.size(), 2U);
  EXPECT_EQ(
      id_error("<lowpass_cutoff_frequency_for_coordinates>0</lowpass_cutoff_frequency_for_coordinates>"),
      "InverseDynamicsTool: has the lowpass_cutoff_frequency_for_coordinates 0, expected Hz above zero, or a "
      "number below zero for no filter");
  EXPECT_EQ(id_error("<time_range>now</time_range>"), "time_range: is 'now', expected its start and its end");
}

}  // namespace
}  // namespace borelli::test::ik_setup_test
