// MuJoCo's models, with files that they include and meshes.
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_mjcf {

const std::string arm = R"(<mujoco model="arm">
  <compiler angle="degree" autolimits="true"/>
  <option timestep="0.002" gravity="0 0 -9.81" integrator="RK4"/>
  <default>
    <joint damping="0.1" armature="0.01"/>
    <default class="soft"><geom density="500" rgba="1 0 0 1"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 .1"/>
    <body name="upper" pos="0 0 1" euler="0 30 0">
      <joint name="shoulder" type="ball" range="0 80"/>
      <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".04"/>
      <site name="tip" pos="0 0 -.3"/>
      <body name="lower" pos="0 0 -.3">
        <joint name="elbow" axis="0 1 0" range="-120 0" stiffness="2" springref="-10"/>
        <geom class="soft" type="box" size=".03 .03 .15" pos="0 0 -.15" contype="0"/>
      </body>
    </body>
    <body name="free" pos="1 0 2"><freejoint/><inertial pos="0 0 0" mass="2" diaginertia=".1 .2 .3"/>
      <geom size=".1"/></body>
  </worldbody>
  <equality><joint joint1="elbow" polycoef="0 1 0 0 0" active="false"/></equality>
  <actuator><motor joint="elbow" gear="10"/></actuator>
  <keyframe><key qpos="1 0 0 0 0 1 0 2 1 0 0 0"/></keyframe>
</mujoco>
)";

std::vector<TestCase> seeds() {
  std::vector<TestCase> out{
      {"arm", {{"a.xml", arm}}},
      {"include",
       {{"a.xml",
         "<mujoco><include file=\"b.xml\"/><worldbody><body><joint/><geom size=\".1\"/>"
         "<include file=\"c.xml\"/></body></worldbody></mujoco>\n"},
        {"b.xml",
         "<mujocoinclude><option gravity=\"0 0 -1\"/><default><geom density=\"10\"/></default>"
         "</mujocoinclude>\n"},
        {"c.xml",
         "<mujocoinclude><body pos=\"0 0 1\"><joint type=\"slide\"/><geom size=\".2\"/></body>"
         "</mujocoinclude>\n"}}},
      {"mesh",
       {{"a.xml",
         "<mujoco><asset><mesh name=\"m\" file=\"m.stl\" scale=\"1 1 2\"/></asset><worldbody><body>"
         "<freejoint/><geom type=\"mesh\" mesh=\"m\"/></body></worldbody></mujoco>\n"},
        {"m.stl", tetrahedron_stl()}}},
      {"connect",
       {{"a.xml",
         "<mujoco><worldbody><body name=\"p\"><joint name=\"j\" axis=\"0 1 0\"/>"
         "<geom type=\"cylinder\" size=\".1 .2\" pos=\".3 0 0\"/></body>"
         "<body name=\"q\" pos=\"1 0 0\"><joint axis=\"0 1 0\"/>"
         "<geom type=\"ellipsoid\" size=\".1 .2 .3\" quat=\"1 1 0 0\"/></body></worldbody>"
         "<equality><connect body1=\"p\" body2=\"q\" anchor=\".5 0 0\"/></equality></mujoco>\n"}}}};
  for (TestCase& test : shared_cases({"models/bench/chain3d2.xml", "models/bench/roundabout.xml",
                                      "models/bench/human_contact.xml", "models/humanoid.xml"})) {
    // its includes lie in another folder
    test.may_be_refused = test.name == "humanoid";
    out.push_back(std::move(test));
  }
  return out;
}

}  // namespace of_mjcf

Reader mjcf_reader() { return {"mjcf", of_mjcf::seeds, try_model}; }

}  // namespace borelli::mutation
