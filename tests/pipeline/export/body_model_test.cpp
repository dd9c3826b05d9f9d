// The phantom's body as a model of OpenSim: it moves as the scene does, and its landmarks are the phantom's.
#include "pipeline/export/body_model.hpp"

#include <gtest/gtest.h>

#include <random>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/equations/jacobian.hpp"
#include "dynamics/formats/model_file.hpp"
#include "samples/phantom.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::body_model_test {
namespace {

using Eigen::Vector3d;

struct Body {
  Phantom phantom;
  PartInertials parts;
  Scene scene;  // without springs, with landmarks
};

Body moving_body() {
  Body made{build_phantom({}).value(), {}, {}};
  for (std::size_t label = 1; label < parts.size(); ++label)
    made.parts[std::string(parts[label].name)] = made.phantom.exact[label];
  SkeletonOptions options;
  options.leap.reset();
  made.scene =
      with_landmark_markers(build_skeleton(made.parts, made.phantom.landmarks, options).value().scene,
                            made.parts, made.phantom.landmarks);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> speed(-2, 2);
  for (Solid& solid : made.scene.solids)
    for (Switch& one : solid.switches) {
      const int nv = std::visit([](const auto& kind) { return kind.nv; }, one.kind);
      one.v.clear();
      for (int i = 0; i < nv; ++i) one.v.push_back(speed(random));
    }
  return made;
}

const CoordinateInfo* coordinate(const System& system, const std::string& name) {
  for (const CoordinateInfo& info : system.coordinates)
    if (info.name == name) return &info;
  return nullptr;
}

// x, y and z of the scene are x, -z and y there
Vector3d in_ground(const Vector3d& v) { return {v.x(), v.z(), -v.y()}; }

TEST(BodyModel, PhantomMovesAlikeInOpenSimsFormat) {
  const Body body = moving_body();
  const WrittenModel written = write_osim(body.scene).value();
  for (const std::string& line : written.omissions) EXPECT_TRUE(line.starts_with("the run's method")) << line;
  const TestFolder folder;
  const Scene again = read_model(folder.write("body.osim", written.text)).value().scene;
  const System one = compile(body.scene).value(), two = compile(again).value();
  const Evaluation a = evaluate(one, one.initial).value(), b = evaluate(two, two.initial).value();
  EXPECT_EQ(one.nv, two.nv);
  EXPECT_NEAR(a.kinetic_energy, b.kinetic_energy, 1e-12 * a.kinetic_energy);
  EXPECT_LT((in_ground(a.momenta.linear) - b.momenta.linear).norm(), 1e-12 * a.momenta.linear.norm());
  EXPECT_LT((in_ground(a.momenta.angular) - b.momenta.angular).norm(), 1e-12 * a.momenta.angular.norm());
  int compared = 0;  // the root's way, knees and elbows: balls are angles there
  const double scale = a.acceleration.cwiseAbs().maxCoeff();
  for (const CoordinateInfo& info : one.coordinates) {
    if (info.q_size != 1) continue;
    ++compared;
    const CoordinateInfo* same = coordinate(two, info.name);
    ASSERT_TRUE(same) << info.name;
    EXPECT_NEAR(a.acceleration[info.v_index], b.acceleration[same->v_index], 1e-12 * scale) << info.name;
  }
  EXPECT_EQ(compared, 7);
}

TEST(BodyModel, LandmarksAreMarkersWhereTheScanShowsThem) {
  const Body body = moving_body();
  EXPECT_EQ(body.scene.markers.size(), body.phantom.landmarks.size());
  const System system = compile(body.scene).value();
  for (const Marker& marker : body.scene.markers) {
    const Vector3d at = point_motion(system, system.initial, marker.at).value().position;
    EXPECT_LT((at - 1e-3 * body.phantom.landmarks.at(marker.name).point).norm(), 1e-12) << marker.name;
  }
  const auto solid_of = [&](std::string_view name) {
    for (const Marker& marker : body.scene.markers)
      if (marker.name == name) return marker.at.solid;
    return std::string();
  };
  EXPECT_EQ(solid_of("knee_lateral_left"), "thigh_left");
  EXPECT_EQ(solid_of("hip_right"), "thigh_right");
  EXPECT_EQ(solid_of("spine_upper"), "upper_trunk");
}

TEST(BodyModel, TellsDeviationsMeshesAndFrames) {
  const Body body = moving_body();
  InertiaTable table;
  table.source.volume = "scan.nii.gz";
  InertiaRow& row = table.rows.emplace_back();
  row.part = "thigh_left";
  row.deviations = {{"mass_kg", 0.125, {}}};
  SegmentFrame& frame = row.frame.emplace();
  frame.R_WA = Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix();
  const ModelExtras extras = body_extras(table, body.parts, body.phantom.landmarks,
                                         {"../mesh/thigh_left.stl", "../mesh/nothing.stl"});
  const auto told = [&](const std::string& part) {
    return std::any_of(extras.comments.begin(), extras.comments.end(),
                       [&](const std::string& line) { return line.find(part) != line.npos; });
  };
  EXPECT_TRUE(told("from scan.nii.gz"));
  EXPECT_TRUE(told("standard deviations of thigh_left: mass 0.125 kg"));
  EXPECT_TRUE(told("joint centre hip_left: standard deviation 0 mm along each axis (exact)"));
  ASSERT_EQ(extras.meshes.size(), 1u);
  EXPECT_EQ(extras.meshes[0].file, "../mesh/thigh_left.stl");
  EXPECT_EQ(extras.meshes[0].position, -1e-3 * body.phantom.landmarks.at("hip_left").point);
  ASSERT_EQ(extras.frames.size(), 1u);
  EXPECT_EQ(extras.frames[0].name, "thigh_left_anatomical");
  EXPECT_EQ(extras.frames[0].pose.R, frame.R_WA);
  EXPECT_EQ(extras.frames[0].pose.p, Vector3d(Vector3d::Zero()));
}

// The verbs write by the ending of -o, and refuse others before any work.
TEST(BodyModel, VerbsWriteByTheEnding) {
  const TestFolder folder;
  const std::string at = folder.path().string() + "/";
  ASSERT_EQ(run_program("phantom -o " + at + "p.nii.gz --spacing 12").code, 0);
  const std::string from = at + "p_table.json --landmarks " + at + "p_landmarks.json -o ";
  for (const char* name : {"body.toml", "body.osim", "body.xml", "body.mjcf", "body.urdf"}) {
    const ProgramRun run = run_program("skeleton " + from + at + name);
    ASSERT_EQ(run.code, 0) << run.err;
    const auto model = read_model(folder / name);
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ(model->scene.markers.empty(),
              std::string_view(name) == "body.toml" || std::string_view(name) == "body.urdf")
        << name;
    EXPECT_EQ(run.err.find("lacks or changes") == run.err.npos, std::string_view(name) == "body.toml")
        << name << run.err;
  }
  const int before = folder.count();
  for (const std::string& verb : {"skeleton " + from, "scale " + at + "body.osim --static none.trc -o "}) {
    const ProgramRun run = run_program(verb + at + "s.osm");
    EXPECT_EQ(run.code, 2);
    EXPECT_NE(run.err.find("has the ending .osm; expected .xml or .mjcf"), run.err.npos) << run.err;
  }
  EXPECT_EQ(folder.count(), before);
}

}  // namespace
}  // namespace borelli::body_model_test
