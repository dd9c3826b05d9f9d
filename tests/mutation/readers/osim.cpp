// OpenSim's models, in the layouts of version 3 and 4.
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_osim {

const std::string knee = R"(<SpatialTransform>
  <TransformAxis name="rotation1"><coordinates>knee</coordinates><axis>0 0 1</axis>
    <LinearFunction><coefficients>1 0</coefficients></LinearFunction></TransformAxis>
  <TransformAxis name="rotation2"><coordinates></coordinates><axis>1 0 0</axis>
    <Constant><value>0.1</value></Constant></TransformAxis>
  <TransformAxis name="translation1"><coordinates>knee</coordinates><axis>1 0 0</axis>
    <MultiplierFunction><function><SimmSpline><x>-2 -1 -0.5 0.2 1</x><y>-0.01 0.01 0 -0.02 -0.01</y></SimmSpline>
    </function><scale>1.1</scale></MultiplierFunction></TransformAxis>
  <TransformAxis name="translation2"><coordinates>knee</coordinates><axis>0 1 0</axis>
    <PolynomialFunction><coefficients>0.01 0.02 -0.4</coefficients></PolynomialFunction></TransformAxis>
</SpatialTransform>)";

const std::string old_model = R"(<?xml version="1.0" encoding="UTF-8" ?>
<OpenSimDocument Version="30000"><Model name="leg"><gravity> 0 -9.80665 0</gravity>
<defaults><Thelen2003Muscle name="default"/></defaults>
<BodySet><objects>
<Body name="ground"><mass>0</mass><mass_center> 0 0 0</mass_center><inertia_xx>0</inertia_xx><Joint /></Body>
<Body name="femur"><mass>9</mass><mass_center> 0 -0.17 0</mass_center><inertia_xx>0.13</inertia_xx>
<inertia_yy>0.03</inertia_yy><inertia_zz>0.14</inertia_zz><inertia_xy>0</inertia_xy><inertia_xz>0</inertia_xz>
<inertia_yz>0</inertia_yz><Joint><BallJoint name="hip"><parent_body>ground</parent_body>
<location_in_parent>0 1 0</location_in_parent><orientation_in_parent>0 0.1 0</orientation_in_parent>
<location>0 0 0</location><orientation>0 0 0</orientation><CoordinateSet><objects>
<Coordinate name="hx"><default_value>0.2</default_value><range>-1.5 1.5</range><clamped>true</clamped></Coordinate>
<Coordinate name="hy"><default_speed_value>1</default_speed_value></Coordinate>
<Coordinate name="hz"><locked>true</locked></Coordinate></objects><groups /></CoordinateSet>
<reverse>false</reverse></BallJoint></Joint></Body>
<Body name="tibia"><mass>4</mass><mass_center> 0 -0.18 0</mass_center><inertia_xx>0.05</inertia_xx>
<inertia_yy>0.005</inertia_yy><inertia_zz>0.05</inertia_zz><Joint><CustomJoint name="knee_joint">
<parent_body>femur</parent_body><CoordinateSet><objects><Coordinate name="knee"/></objects></CoordinateSet>
<reverse>true</reverse>)" + knee +
                              R"(</CustomJoint></Joint></Body>
</objects></BodySet>
<ConstraintSet><objects><ConstantDistanceConstraint name="rod"><isDisabled>true</isDisabled><body_1>tibia</body_1>
<body_2>ground</body_2><constant_distance>1</constant_distance></ConstantDistanceConstraint></objects></ConstraintSet>
<MarkerSet><objects><Marker name="heel"><body>tibia</body><location>0 -0.4 0</location></Marker></objects></MarkerSet>
<ForceSet><objects><Thelen2003Muscle name="vasti"/></objects></ForceSet></Model></OpenSimDocument>
)";

std::string frame(const std::string& name, const std::string& body) {
  return "<PhysicalOffsetFrame name=\"" + name + "\"><socket_parent>" + body +
         "</socket_parent><translation>0 0.1 0</translation><orientation>0 0 0.1</orientation>"
         "</PhysicalOffsetFrame>";
}

const std::string new_model =
    R"(<?xml version="1.0" encoding="UTF-8" ?>
<OpenSimDocument Version="40000"><Model name="leg"><Ground name="ground"/><gravity>0 -9.80665 0</gravity>
<BodySet name="bodyset"><objects>
<Body name="femur"><mass>9</mass><mass_center>0 -0.17 0</mass_center><inertia>0.13 0.03 0.14 0 0 0</inertia>
<attached_geometry><Mesh name="bone"><mesh_file>femur.vtp</mesh_file></Mesh></attached_geometry></Body>
<Body name="tibia"><mass>4</mass><mass_center>0 -0.18 0</mass_center><inertia>0.05 0.005 0.05 0 0 0</inertia></Body>
<Body name="patella"><mass>0.1</mass><inertia>1e-5 1e-5 1e-5 0 0 0</inertia></Body>
</objects></BodySet>
<JointSet name="jointset"><objects>
<FreeJoint name="hip"><socket_parent_frame>/ground</socket_parent_frame>
<socket_child_frame>/bodyset/femur</socket_child_frame></FreeJoint>
<CustomJoint name="knee_joint"><socket_parent_frame>on_femur</socket_parent_frame>
<socket_child_frame>on_tibia</socket_child_frame><coordinates><Coordinate name="knee"><default_value>-0.3</default_value>
<prescribed_function><Sine><amplitude>1</amplitude></Sine></prescribed_function></Coordinate></coordinates><frames>)" +
    frame("on_femur", "/bodyset/femur") + frame("on_tibia", "../../../bodyset/tibia") + "</frames>" + knee +
    R"(</CustomJoint>
<SliderJoint name="groove"><socket_parent_frame>/bodyset/femur</socket_parent_frame>
<socket_child_frame>/bodyset/patella</socket_child_frame><coordinates><Coordinate name="glide"/></coordinates>
</SliderJoint></objects></JointSet>
<ConstraintSet name="constraintset"><objects><CoordinateCouplerConstraint name="follow">
<coupled_coordinates_function><LinearFunction><coefficients>0.05 0.01</coefficients></LinearFunction>
</coupled_coordinates_function><independent_coordinate_names>knee</independent_coordinate_names>
<dependent_coordinate_name>glide</dependent_coordinate_name></CoordinateCouplerConstraint></objects></ConstraintSet>
<ForceSet name="forceset"><objects><PointToPointSpring name="band"><socket_body1>/bodyset/tibia</socket_body1>
<socket_body2>/ground</socket_body2><stiffness>10</stiffness><rest_length>0.2</rest_length></PointToPointSpring>
</objects></ForceSet>
<MarkerSet name="markerset"><objects><Marker name="heel"><socket_parent_frame>/bodyset/tibia</socket_parent_frame>
<location>0 -0.4 0</location></Marker></objects></MarkerSet></Model></OpenSimDocument>
)";

std::vector<TestCase> seeds() {
  return {{"old", {{"old.osim", old_model}}}, {"new", {{"new.osim", new_model}}}};
}

}  // namespace of_osim

Reader osim_reader() { return {"osim", of_osim::seeds, try_model}; }

}  // namespace borelli::mutation
