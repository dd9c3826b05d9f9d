// Numbers of a scene's text, by path: found and changed, with the rest unchanged.
#include "pipeline/charts/scene_number.hpp"

#include <gtest/gtest.h>

#include "dynamics/formats/scene_file.hpp"

namespace borelli {
namespace {

const std::string text = R"(name = "Prüfstand"  # µ: two bytes before the number
gravity = [0, 0, -9.81]
[simulation]
end_time = 2

[[solid]]
name = "bar é"
joint = [{fixed = [0, 0, -1]}, {rotation = "y", name = "swing", value = 0.5}]
mass = 1
centre = [0, 0, -0.5]
tensor = [0.1, 0.1, 0.01]

[[effort]]  # holds it
name = "spring"
kind = "coordinate_spring"
on = "swing"
stiffness = 4e2 # N m
damping = +1_0.5
)";

double number(const std::string& path) { return number_at(text, "t.toml", path).value(); }

TEST(SceneNumber, IsFoundByKeysIndicesAndNames) {
  EXPECT_EQ(number("simulation.end_time"), 2);
  EXPECT_EQ(number("gravity[2]"), -9.81);
  EXPECT_EQ(number("solid[bar é].joint[swing].value"), 0.5);
  EXPECT_EQ(number("solid[0].joint[1].value"), 0.5);
  EXPECT_EQ(number("effort[spring].stiffness"), 400);
  EXPECT_EQ(number("spring.stiffness"), 400);
  EXPECT_EQ(number("spring.damping"), 10.5);
  EXPECT_EQ(number("bar é.mass"), 1);
}

TEST(SceneNumber, ChangesNothingElseInTheFile) {
  for (const char* path : {"simulation.end_time", "gravity[2]", "solid[bar é].joint[swing].value",
                           "spring.stiffness", "spring.damping", "bar é.tensor[1]", "bar é.mass"})
    for (const double value : {1.25, 3., 1e-300, 1e30, 0.1 + 0.2}) {
      const auto changed = with_number(text, "t.toml", path, value);
      ASSERT_TRUE(changed) << changed.error().message();
      EXPECT_EQ(number_at(*changed, "t.toml", path).value(), value) << path;
      // changing it back gives the same text, except for the number's notation
      const auto back = with_number(*changed, "t.toml", path, number(path));
      EXPECT_TRUE(parse_scene(*back, "t.toml")) << *back;
      EXPECT_EQ(std::count(changed->begin(), changed->end(), '\n'),
                std::count(text.begin(), text.end(), '\n'));
    }
  const Scene scene = parse_scene(*with_number(text, "t.toml", "spring.stiffness", 7), "t.toml").value();
  EXPECT_EQ(std::get<CoordinateSpring>(scene.efforts[0].kind).stiffness, 7);
  EXPECT_EQ(std::get<CoordinateSpring>(scene.efforts[0].kind).damping, 10.5);
}

TEST(SceneNumber, OfTheSimulationMayBeAdded) {
  const auto more = with_number(text, "t.toml", "simulation.baumgarte_alpha", 20);
  EXPECT_EQ(parse_scene(*more, "t.toml").value().simulation.baumgarte_alpha, 20);
  const std::string bare = text.substr(text.find("[[solid]]"));
  EXPECT_EQ(
      parse_scene(*with_number(bare, "t.toml", "simulation.step", 0.25), "t.toml").value().simulation.step,
      0.25);
  // reading the scene refuses unknown settings
  EXPECT_FALSE(parse_scene(*with_number(text, "t.toml", "simulation.stepp", 1), "t.toml"));
}

TEST(SceneNumber, ThatIsMissingNamesSimilarOnes) {
  for (const char* path : {"effort[sprin].stiffness", "spring.stifness", "solid[3].mass", "", "spring", "[",
                           "simulation.end_time.x", "bar é.name"}) {
    const auto refused = with_number(text, "t.toml", path, 1);
    ASSERT_FALSE(refused) << path;
    EXPECT_EQ(refused.error().kind, Error::Kind::use);
    EXPECT_NE(refused.error().message().find("t.toml: has no number at '"), std::string::npos);
  }
  EXPECT_NE(with_number(text, "t.toml", "effort[sprin].stiffness", 1)
                .error()
                .message()
                .find("the nearest are effort[spring].stiffness, "),
            std::string::npos);
  // suggests all elements that the path names, although others are spelt more similarly
  EXPECT_NE(
      with_number(text, "t.toml", "spring.k", 1).error().message().find("the nearest are effort[spring]."),
      std::string::npos);
}

}  // namespace
}  // namespace borelli
