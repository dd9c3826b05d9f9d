// The picture: positions of its contents, from its pixels. No display is needed.
#include "pipeline/export/render.hpp"

#include <gtest/gtest.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "pipeline/files/palette.hpp"

namespace borelli {
namespace {

Mesh box(const std::string& name, const Eigen::Vector3f& least, const Eigen::Vector3f& greatest) {
  Mesh mesh;
  mesh.name = name;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3f p;
    for (int c = 0; c < 3; ++c) p[c] = corner >> c & 1 ? greatest[c] : least[c];
    mesh.points.push_back(p);
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

class Picture : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "borelli-picture-XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::filesystem::path folder_;
};

// the part with the nearest colour by hue, since light changes brightness only
std::string part_at(vtkImageData& image, double across, double up) {
  int size[3];
  image.GetDimensions(size);
  const auto* pixel = static_cast<unsigned char*>(
      image.GetScalarPointer(static_cast<int>(across * size[0]), static_cast<int>(up * size[1]), 0));
  const Eigen::Vector3d seen = Eigen::Vector3d(pixel[0], pixel[1], pixel[2]).normalized();
  std::string best = "background";
  double nearest = 0.12;
  if (pixel[0] > 225 && pixel[1] > 225 && pixel[2] > 225) return best;
  for (const char* name : {"head", "thigh_left", "thigh_right"}) {
    const Colour c = part_colour(name);
    const double apart = (Eigen::Vector3d(c.red, c.green, c.blue).normalized() - seen).norm();
    if (apart < nearest) nearest = apart, best = name;
  }
  return best;
}

TEST_F(Picture, ShowsPartsAtTheirPlaces) {
  // a head above, the left thigh on the patient's left (x > 0), the right one on the right; the left one
  // further back
  const std::vector<Mesh> body{box("head", {-0.1f, -0.1f, 1.5f}, {0.1f, 0.1f, 1.8f}),
                               box("thigh_left", {0.05f, 0.0f, 0.0f}, {0.25f, 0.2f, 1.4f}),
                               box("thigh_right", {-0.25f, -0.1f, 0.0f}, {-0.05f, 0.1f, 1.4f})};
  ASSERT_TRUE(draw_body(file("a.png"), body, {.height = 600, .joints = {{0.15, 0.1, 0.7}}}));
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(file("a.png").c_str());
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  int size[3];
  image.GetDimensions(size);
  EXPECT_EQ(size[1], 600);
  // widths of the strips: body and a tenth of its height, x 0.5 + 0.18, y 0.3 + 0.18
  const double seam = 0.68 / (0.68 + 0.48);
  const auto up = [](double z) { return 0.5 + (z - 0.9) / (2 * 0.54 * 1.8); };
  EXPECT_EQ(part_at(image, seam / 2, up(1.65)), "head");
  // the body faces us: its left is at our right
  EXPECT_EQ(part_at(image, seam * (0.5 + 0.10 / 0.68), up(0.4)), "thigh_left");
  EXPECT_EQ(part_at(image, seam * (0.5 - 0.15 / 0.68), up(0.4)), "thigh_right");
  EXPECT_EQ(part_at(image, 0.01, 0.5), "background");
  // from the left the left thigh is in front; forward (-y) is to our left
  const double middle = 0.05;  // of y from -0.1 to 0.2
  const auto across = [&](double y) { return seam + (1 - seam) * (0.5 + (y - middle) / 0.48); };
  EXPECT_EQ(part_at(image, across(0.15), up(0.4)), "thigh_left");
  EXPECT_EQ(part_at(image, across(-0.05), up(0.4)), "thigh_right");
  // the joint inside the left thigh is seen through it, as a dark ball
  const auto* pixel = static_cast<unsigned char*>(image.GetScalarPointer(
      static_cast<int>(seam * (0.5 + 0.15 / 0.68) * size[0]), static_cast<int>(up(0.7) * 600), 0));
  EXPECT_LT(pixel[0], 90);
  EXPECT_LT(pixel[1], 90);
}

TEST_F(Picture, DoesNotAskForADisplay) {
  const char* const display = std::getenv("DISPLAY");
  const std::string before = display ? display : "";
  for (const char* none : {"", ":4711"}) {
    setenv("DISPLAY", none, 1);
    EXPECT_TRUE(can_draw());
    const auto drawn = draw_body(file("a.png"), {box("head", {0, 0, 0}, {1, 1, 1})});
    EXPECT_TRUE(drawn) << drawn.error().message();
  }
  before.empty() ? unsetenv("DISPLAY") : setenv("DISPLAY", before.c_str(), 1);
}

// EGL's vendors are listed in files; without one there is no driver. Runs in its own process, because EGL
// reads the list once.
TEST_F(Picture, SaysWhatToInstallWithoutADriver) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere.json", 1);
        const auto fine = can_draw();
        std::fprintf(stderr, "%s\n", fine ? "draws" : fine.error().message().c_str());
        std::_Exit(0);
      },
      ::testing::ExitedWithCode(0), "libegl-mesa0");
}

TEST_F(Picture, RefusesEmptyMeshesAndUnwritablePaths) {
  EXPECT_FALSE(draw_body(file("a.png"), {}));
  EXPECT_FALSE(draw_body(file("no/folder/a.png"), {box("head", {0, 0, 0}, {1, 1, 1})}));
}

}  // namespace
}  // namespace borelli
