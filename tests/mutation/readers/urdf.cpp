// URDF models, with a fixed root and a floating one.
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_urdf {

const std::string arm = R"(<?xml version="1.0"?>
<robot name="arm">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0 0 0.15" rpy="0 0.1 0"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.002"/></inertial>
    <visual><geometry><cylinder radius="0.03" length="0.3"/></geometry><material name="grey"/></visual>
    <collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision>
  </link>
  <link name="lower">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial>
  </link>
  <link name="finger">
    <inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
  </link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.1" rpy="0 0 1.57"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1.5" effort="10" velocity="3"/><dynamics damping="0.1" friction="0.2"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
  <joint name="grip" type="prismatic"><parent link="lower"/><child link="finger"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.05" effort="1" velocity="1"/><mimic joint="elbow" multiplier="0.01" offset="0"/></joint>
  <joint name="end" type="fixed"><parent link="finger"/><child link="tip"/></joint>
</robot>
)";

std::vector<TestCase> seeds() {
  std::string floating = arm;
  floating.replace(floating.find("<link name=\"base\"/>"), 19,
                   "<link name=\"base\"><inertial><mass value=\"5\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" "
                   "iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>");
  std::vector<TestCase> out{{"arm", {{"a.urdf", arm}}}, {"floating", {{"floating.urdf", floating}}}};
  for (TestCase& test : shared_cases({"models/bench/chain3d2.urdf", "models/bench/roundabout.urdf"}))
    out.push_back(std::move(test));
  return out;
}

}  // namespace of_urdf

Reader urdf_reader() { return {"urdf", of_urdf::seeds, try_model}; }

}  // namespace borelli::mutation
