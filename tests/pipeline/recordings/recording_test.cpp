// Kinds of recordings recognised by their content, and force plates found in tables.
#include "pipeline/recordings/recording.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/paths.hpp"

namespace borelli::test::recording_test {
namespace {

MotionTable table_with(const std::vector<std::string>& columns) {
  MotionTable table{"forces", columns, {0, 1}, Eigen::MatrixXd(2, columns.size()), false};
  for (Eigen::Index c = 0; c < table.values.cols(); ++c) table.values.col(c) << 0, double(c + 1);
  return table;
}

TEST(Recording, KindIsFoundFromTheContent) {
  const auto trc = read_recording(shared_folder() + "/motion/gait10dof/subject01_walk.trc");
  ASSERT_TRUE(trc);
  EXPECT_EQ(trc->markers.names.size(), 41u);
  EXPECT_TRUE(trc->forces.empty());
  const auto c3d = read_recording(shared_folder() + "/motion/Movement_trial.c3d");
  ASSERT_TRUE(c3d);
  EXPECT_EQ(c3d->forces.size(), 4u);
  ASSERT_TRUE(c3d->markers.up);
  const auto bvh = read_recording(shared_folder() + "/motion/walk1.bvh");
  ASSERT_TRUE(bvh);
  EXPECT_FALSE(bvh->warnings.empty());  // its unit is a guess
  const auto other = read_recording(shared_folder() + "/motion/gait10dof/subject01_walk_IK.mot");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().what.find("is not a recording of markers"), std::string::npos);
  EXPECT_FALSE(read_recording("/nowhere/walk.trc"));
}

TEST(Recording, FindsForcePlatesByTheNamesOfColumns) {
  const auto forces = forces_in(table_with(
      {"ground_force_vx", "ground_force_vy", "ground_force_vz", "ground_force_px", "ground_force_py",
       "ground_force_pz", "1_ground_force_vx", "1_ground_force_vy", "1_ground_force_vz", "1_ground_force_px",
       "1_ground_force_py", "1_ground_force_pz", "ground_torque_x", "ground_torque_y", "ground_torque_z"}));
  ASSERT_TRUE(forces);
  ASSERT_EQ(forces->size(), 2u);
  EXPECT_EQ((*forces)[0].force.col(1), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*forces)[0].point.col(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ((*forces)[0].moment.col(1), Eigen::Vector3d(13, 14, 15));
  EXPECT_EQ((*forces)[1].force.col(1), Eigen::Vector3d(7, 8, 9));
  EXPECT_TRUE((*forces)[1].moment.isZero());
  EXPECT_TRUE(std::isnan((*forces)[0].point(0, 0)));  // no force, no point
}

TEST(Recording, RefusesForcesWithoutAPoint) {
  EXPECT_FALSE(forces_in(table_with({"f_vx", "f_vy", "f_vz"})));
  EXPECT_FALSE(forces_in(table_with({"f_vx", "f_vy", "f_px", "f_py", "f_pz"})));
  EXPECT_FALSE(forces_in(table_with({"hip", "knee"})));
}

}  // namespace
}  // namespace borelli::test::recording_test
