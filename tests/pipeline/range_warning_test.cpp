#include "pipeline/report/range_warning.hpp"

#include <gtest/gtest.h>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"

namespace borelli {
namespace {

// Warnings for a sphere that turns at 2 rad/s about its z axis and one that slides at 1 m/s, without forces.
std::vector<std::string> said_of(const std::string& turn_range, const std::string& slide_range,
                                 Certificate* certificate = nullptr) {
  const auto scene = parse_scene(R"(
gravity = [0, 0, 0]
[[solid]]
name = "globe"
joint = { ball = true, name = "shoulder_left", velocity = [0, 0, 2], range_deg = )" +
                                     turn_range + R"( }
mass = 1
centre = [0, 0, 0]
tensor = [0.1, 0.1, 0.1]
[[solid]]
name = "carriage"
joint = { translation = "x", name = "slide", velocity = 1, range = )" +
                                     slide_range + R"( }
mass = 1
centre = [0, 0, 0]
tensor = [0.1, 0.1, 0.1]
[simulation]
end_time = 1.0
)",
                                 "scene.toml");
  EXPECT_TRUE(scene) << scene.error().message();
  const auto system = compile(*scene);
  EXPECT_TRUE(system) << system.error().message();
  const auto trajectory = simulate(*system, system->initial, system->settings);
  EXPECT_TRUE(trajectory) << trajectory.error().message();
  if (certificate) *certificate = trajectory->certificate;
  return warnings_of(trajectory->certificate, *system);
}

using Warnings = std::vector<std::string>;
const std::string wide = "[[-90, 90], [-90, 90], [-170, 170]]";

TEST(RangeWarning, IsOneSentenceForAllJoints) {
  Certificate certificate;
  // passes 30 degrees at pi / 6 / 2 s = .2618 s, and half a metre at .5 s
  EXPECT_EQ(
      said_of("[[-90, 90], [-90, 90], [-10, 30]]", "[-1, 0.5]", &certificate),
      Warnings{"2 joints leave their usual ranges, first shoulder_left (about its z axis, above 30 deg) "
               "at t = 0.262 s; ranges are not enforced"});
  EXPECT_EQ(certificate.notes.size(), 2u);  // the certificate keeps all of them
  EXPECT_EQ(said_of(wide, "[-1, 0.5]"),
            Warnings{"a joint leaves its usual range, slide (above 0.5 m) at t = 0.500 s; ranges are not "
                     "enforced"});
  EXPECT_EQ(said_of(wide, "[-1, 2]"), Warnings{});
}

TEST(RangeWarning, KeepsTheOtherNotes) {
  Certificate certificate;
  certificate.notes = {"coordinate 'x' is at a singular position"};
  EXPECT_EQ(warnings_of(certificate, System()), certificate.notes);
}

}  // namespace
}  // namespace borelli
