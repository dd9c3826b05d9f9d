// Scene files with errors are refused with their line.
#include "dynamics/formats/scene_file.hpp"

#include <gtest/gtest.h>

namespace borelli::test::scene_file_refusal_test {
namespace {

const std::string solid_a =
    "[[solid]]\nname = 'a'\njoint = {rotation = 'z', name = 'qa'}\nmass = 1\ntensor = [1, 1, 1]\n";

struct Refused {
  const char* title;
  std::string text;
  int line;
  const char* said;
};

class SceneFileRefusal : public ::testing::TestWithParam<Refused> {};

TEST_P(SceneFileRefusal, NamesTheLine) {
  const Refused& r = GetParam();
  const auto answer = parse_scene(r.text, "scene.toml");
  ASSERT_FALSE(answer) << r.text;
  const std::string message = answer.error().message();
  EXPECT_EQ(answer.error().where, "scene.toml:" + std::to_string(r.line)) << message;
  EXPECT_NE(message.find(r.said), std::string::npos) << message;
  EXPECT_EQ(answer.error().kind, Error::Kind::use);
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Bad, SceneFileRefusal,
    ::testing::Values(
        Refused{"syntax", "gravity = [0, 0\nname = 1", 2, ""},
        Refused{"unknown_key", solid_a + "masss = 3\n", 6, "unknown key 'masss'"},
        Refused{"unknown_key_at_the_top", "gravty = [0, 0, 1]\n", 1,
                "unknown key 'gravty'; known here: name"},
        Refused{"unknown_key_in_joint", "[[solid]]\nname = 'a'\njoint = [\n {rotation = 'z', nme = 'q'}]\n",
                4, "'nme'"},
        Refused{"unknown_key_in_simulation", "[simulation]\nstep = 1\nstap = 1\n", 3, "unknown key 'stap'"},
        Refused{"wrong_type", "[[solid]]\nname = 'a'\nmass = 'heavy'\n", 3, "expected a number"},
        Refused{"wrong_type_of_list", "gravity = [0, 'down', 1]\n", 1, "the text \"down\""},
        Refused{"text_for_a_joint", "[[solid]]\nname='a'\njoint='ball'\n", 3,
                "joint is the text \"ball\", expected a table or a list of tables"},
        Refused{"number_for_true", "[[solid]]\nname='a'\njoint={ball=1}\n", 3, "expected true or false"},
        Refused{"text_for_a_function", "[[solid]]\nname='a'\njoint={rotation='x', driven='sine'}\n", 3,
                "driven is the text \"sine\", expected a number, a list of polynomial coefficients"},
        Refused{"mixed_tensor", "[[solid]]\nname='a'\nmass=1\ntensor=[[1,0,0],[0,1,0],'x']\n", 4,
                "a row of tensor is the text \"x\""},
        Refused{"table_and_list_of_one_name", "[solid]\nname='a'\n[[solid]]\nname='b'\n", 3, ""},
        Refused{"dotted_key_into_a_list", "gravity=[0,0,1]\ngravity.x=1\n", 2, ""},
        Refused{"wrong_length", "gravity = [0, 1]\n", 1, "a list of 2, expected a list of 3 numbers"},
        Refused{"name_missing", "[[solid]]\nmass = 1\ntensor = [1, 1, 1]\n", 1, "name is missing"},
        Refused{"name_empty", "[[solid]]\nname = ''\n", 2, "name is empty"},
        Refused{"effort_without_name", solid_a + "[[effort]]\nkind = 'torque'\n", 6, "name is missing"},
        Refused{"world_taken", "[[solid]]\nname = 'world'\n", 1, "is reserved for the fixed frame"},
        Refused{"unknown_parent", solid_a + "parent = 'b'\n", 6, "there is no solid named 'b'"},
        Refused{"circle", "[[solid]]\nname='a'\nparent='b'\n[[solid]]\nname='b'\nparent='a'\n", 1,
                "a -> b -> a"},
        Refused{"own_parent", "[[solid]]\nname='a'\nparent='a'\n", 1, "a -> a"},
        Refused{"solid_twice", solid_a + "[[solid]]\nname = 'a'\n", 7, "the first is at scene.toml:2"},
        Refused{"coordinate_twice",
                solid_a + "[[solid]]\nname = 'b'\njoint = {rotation = 'y', name = 'qa'}\n", 8,
                "two coordinates named 'qa'"},
        Refused{
            "effort_twice",
            solid_a + "[[effort]]\nname='t'\nkind='torque'\non='a'\ntorque=[1,0,0]\n[[effort]]\nname='t'\n",
            12, "two efforts named 't'"},
        Refused{"effort_on_nothing",
                solid_a + "[[effort]]\nname='t'\nkind='torque'\non='b'\ntorque=[1,0,0]\n", 9,
                "there is no solid named 'b'"},
        Refused{"effort_without_value", solid_a + "[[effort]]\nname='t'\nkind='torque'\non='a'\n", 6,
                "torque is missing"},
        Refused{"unknown_kind", solid_a + "[[effort]]\nname='t'\nkind='wind'\n", 8, "known: force, torque"},
        Refused{"function_constraint", "[[constraint]]\nname='t'\nkind='function'\n", 3,
                "there is no kind named"},
        Refused{"unknown_coordinate",
                solid_a + "[[effort]]\nname='t'\nkind='coordinate_spring'\non='qb'\nstiffness=1\n", 9,
                "there is no coordinate named 'qb', expected one of: qa"},
        Refused{"unnamed_coordinate_twice", solid_a + "[[solid]]\nname = 'qa'\njoint = {rotation = 'y'}\n", 8,
                "two coordinates named 'qa'"},
        Refused{"zero_axis", "[[solid]]\nname='a'\njoint = {rotation = [0, 0, 0]}\n", 3, "has length 0"},
        Refused{"long_axis", "[[solid]]\nname='a'\njoint = {rotation = [1, 1, 0]}\n", 3,
                "expected a unit vector: [0.707"},
        Refused{"odd_axis", "[[solid]]\nname='a'\njoint = {rotation = 'w'}\n", 3, "expected \"x\""},
        Refused{"two_switches_in_one", "[[solid]]\nname='a'\njoint = {rotation = 'x', ball = true}\n", 3,
                "has rotation and ball"},
        Refused{"no_switch", "[[solid]]\nname='a'\njoint = {name = 'q'}\n", 3, "expected one of fixed"},
        Refused{"degrees_and_radians", "[[solid]]\nname='a'\njoint = {rotation='x', value=1, value_deg=2}\n",
                3, "expected one of them"},
        Refused{"degrees_of_a_slide", "[[solid]]\nname='a'\njoint = {translation='x', value_deg=2}\n", 3,
                "unknown key 'value_deg'"},
        Refused{"rest_degrees_of_a_slide",
                "[[solid]]\nname='a'\njoint={translation='x',name='q'}\n"
                "[[effort]]\nname='s'\nkind='coordinate_spring'\non='q'\nrest_deg=3\n",
                7, "'q' is a translation"},
        Refused{"long_quaternion", "[[solid]]\nname='a'\njoint = {ball = true, value = [1, 1, 0, 0]}\n", 3,
                "expected a unit quaternion: [0.707"},
        Refused{"nan", "[[solid]]\nname='a'\nmass = nan\ntensor=[1,1,1]\n", 3, "expected a finite number"},
        Refused{"infinite", "gravity = [0, 0, -inf]\n", 1, "expected a finite number"},
        Refused{"negative_mass", "[[solid]]\nname='a'\nmass = -1\ntensor=[1,1,1]\n", 3, "-1"},
        Refused{"not_positive", "[[solid]]\nname='a'\nmass = 1\ntensor=[1,1,-0.25]\n", 4, "-0.25"},
        Refused{"not_positive_by_products", "[[solid]]\nname='a'\nmass = 1\ntensor=[1,1,1,2,0,0]\n", 4, "-1"},
        Refused{"triangle_broken", "[[solid]]\nname='a'\nmass = 1\ntensor=[1,2,3.5]\n", 4, "3.5"},
        Refused{"mass_without_tensor", "[[solid]]\nname='a'\nmass = 1\nshape = {kind='sphere', radius=1}\n",
                3, "mass needs a tensor"},
        Refused{"tensor_without_mass", "[[solid]]\nname='a'\ntensor=[1,1,1]\n", 3, "mass is missing"},
        Refused{"shape_size", "[[solid]]\nname='a'\nshape={kind='sphere', radius=-2, mass=1}\n", 3,
                "radius is -2"},
        Refused{"shape_kind", "[[solid]]\nname='a'\nshape={kind='egg', mass=1}\n", 3,
                "there is no shape named \"egg\""},
        Refused{"shape_mass_and_density",
                "[[solid]]\nname='a'\nshape={kind='sphere', radius=1, mass=1, density=2}\n", 3,
                "density and a mass"},
        Refused{"open_mesh",
                "[[solid]]\nname='a'\nshape={kind='mesh', mass=1, vertices=[[0,0,0],[1,0,0],[0,1,0]], "
                "triangles=[[0,1,2]]}\n",
                3, "is not closed"},
        Refused{"mesh_index",
                "[[solid]]\nname='a'\nshape={kind='mesh', vertices=[[0,0,0]], triangles=[[0,1,2]]}\n", 3,
                "refers to vertex 1"},
        Refused{"velocity_of_locked", "[[solid]]\nname='a'\njoint={rotation='x', locked=true, velocity=1}\n",
                3, "only a free coordinate"},
        Refused{"value_of_driven", "[[solid]]\nname='a'\njoint={rotation='x', driven=[0,1], value=1}\n", 3,
                "takes the value of its function"},
        Refused{"range_upside_down", "[[solid]]\nname='a'\njoint={rotation='x', range=[1,0]}\n", 3,
                "runs from 1 to 0"},
        Refused{"range_of_three_numbers", "[[solid]]\nname='a'\njoint={rotation='x', range=[0,1,2]}\n", 3,
                "range is a list of 3, expected a list of 2 numbers"},
        Refused{"ranges_of_a_hinge", "[[solid]]\nname='a'\njoint={rotation='x', range=[[0,1]]}\n", 3,
                "expected a list of 2 numbers"},
        Refused{"range_without_end", "[[solid]]\nname='a'\njoint={rotation='x', range=[0,inf]}\n", 3,
                "expected a finite number"},
        Refused{"range_of_driven", "[[solid]]\nname='a'\njoint={rotation='x', driven=[0], range=[0,1]}\n", 3,
                "a range has no effect"},
        Refused{"one_range_of_a_ball", "[[solid]]\nname='a'\njoint={ball=true, range=[0,1]}\n", 3,
                "expected three ranges"},
        Refused{"numbers_for_a_balls_ranges", "[[solid]]\nname='a'\njoint={ball=true, range=[0,1,2]}\n", 3,
                "one of its ranges is the number 0"},
        Refused{"ball_range_upside_down",
                "[[solid]]\nname='a'\njoint=[{fixed=[0,0,0]},\n{ball=true, range=[[0,1],[1,0],[0,1]]}]\n", 4,
                "range about its y axis runs from 1 to 0"},
        Refused{
            "ball_outside_its_range",
            "[[solid]]\nname='a'\njoint={ball=true, value=[0.8,0,0,0.6], range_deg=[[0,1],[0,1],[0,60]]}\n",
            3, "about its z axis, outside its range of 0 to 1.047"},
        Refused{"value_outside_range", "[[solid]]\nname='a'\njoint={rotation='x', value=2, range=[0,1]}\n", 3,
                "starts at 2, outside its range of 0 to 1 (rad)"},
        Refused{"no_value_outside_range", "[[solid]]\nname='a'\njoint={translation='x', range=[1,2]}\n", 3,
                "starts at 0, outside its range of 1 to 2 (m)"},
        Refused{"unknown_method", "[simulation]\nmethod='magic'\n", 2,
                "expected one of euler, rk2, rk4, rk4_adaptive"},
        Refused{"method_beside_accuracy", "[simulation]\naccuracy=1e-3\nmethod='rk4'\n", 3,
                "method has no effect with accuracy"},
        Refused{"tolerance_beside_accuracy", "[simulation]\ntolerance=1e-3\naccuracy=1e-3\n", 2,
                "tolerance has no effect with accuracy"},
        Refused{"negative_damping",
                "[[solid]]\nname='a'\njoint={rotation='x'}\n[[effort]]\nname='s'\nkind='coordinate_spring'\n"
                "on='a'\ndamping=-1\n",
                8, "damping is -1, expected 0 or more"},
        Refused{"bad_treatment", "[simulation]\nconstraints='magic'\n", 2, "projection"},
        Refused{"bad_equations", "[simulation]\nequations='newton'\n", 2,
                "equations is \"newton\", expected \"recursive\" or \"lagrange\""},
        Refused{"step_of_nothing", "[simulation]\nstep=0\n", 2, "expected a positive number"},
        Refused{"sine_field", "[[solid]]\nname='a'\njoint={rotation='x', driven={kind='sine', amplitud=1}}\n",
                3, "unknown key 'amplitud'"},
        Refused{"not_a_rotation",
                "[[solid]]\nname='a'\njoint={fixed=[0,0,0], matrix=[[1,0,0],[0,1,0],[0,0,-1]]}\n", 3,
                "not a rotation"}),
    [](const auto& param) { return std::string(param.param.title); });

}  // namespace
}  // namespace borelli::test::scene_file_refusal_test
