// STL by its bytes, PLY, OBJ and VTP by VTK's own readers.
#include "pipeline/export/mesh_file.hpp"

#include <gtest/gtest.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace borelli {
namespace {

const Mesh tetrahedron{
    "head", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

class MeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "borelli-mesh-XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::filesystem::path folder_;
};

TEST_F(MeshFile, StlContainsItsTriangles) {
  ASSERT_TRUE(write_stl(file("a.stl"), tetrahedron));
  std::ifstream in(file("a.stl"), std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(bytes.size(), 84u + 4 * 50);
  EXPECT_NE(std::string(bytes.data(), 5), "solid") << "that word would make it a text STL";
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  EXPECT_EQ(count, 4u);
  std::array<float, 12> second;  // triangle 0 1 3: in the plane y = 0, facing -y
  std::memcpy(second.data(), bytes.data() + 84 + 50, 48);
  EXPECT_EQ(second, (std::array<float, 12>{0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2}));
}

void expect_tetrahedron_in_millimetres(vtkPolyData& read) {
  ASSERT_EQ(read.GetNumberOfPoints(), 4);
  ASSERT_EQ(read.GetNumberOfPolys(), 4);
  EXPECT_EQ(read.GetPoint(3)[2], 2000);
  for (vtkIdType n = 0; n < 4; ++n)
    for (int corner = 0; corner < 3; ++corner)
      EXPECT_EQ(read.GetCell(n)->GetPointId(corner),
                tetrahedron.triangles[static_cast<std::size_t>(n)][static_cast<std::size_t>(corner)]);
}

TEST_F(MeshFile, VtkReadsPlyAndObjInMillimetres) {
  ASSERT_TRUE(write_ply(file("a.ply"), tetrahedron, MeshUnit::millimetre));
  vtkNew<vtkPLYReader> ply;
  ply->SetFileName(file("a.ply").c_str());
  ply->Update();
  expect_tetrahedron_in_millimetres(*ply->GetOutput());
  ASSERT_TRUE(write_obj(file("a.obj"), tetrahedron, MeshUnit::millimetre));
  vtkNew<vtkOBJReader> obj;
  obj->SetFileName(file("a.obj").c_str());
  obj->Update();
  expect_tetrahedron_in_millimetres(*obj->GetOutput());
}

TEST_F(MeshFile, VtpHoldsLabelDensityAndUnit) {
  Mesh mesh = tetrahedron;
  mesh.label = 7;
  mesh.density = 1062.5;
  ASSERT_TRUE(write_vtp(file("a.vtp"), mesh, MeshUnit::millimetre));
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file("a.vtp").c_str());
  reader->Update();
  vtkPolyData& read = *reader->GetOutput();
  expect_tetrahedron_in_millimetres(read);
  const auto text = [&](const char* name) {
    return vtkStringArray::SafeDownCast(read.GetFieldData()->GetAbstractArray(name))->GetValue(0);
  };
  EXPECT_EQ(text("unit"), "mm");
  EXPECT_EQ(text("SPACE"), "LPS");
  for (vtkIdType n = 0; n < 4; ++n) {
    EXPECT_EQ(read.GetCellData()->GetArray("label")->GetTuple1(n), 7);
    EXPECT_EQ(read.GetCellData()->GetArray("density")->GetTuple1(n), 1062.5);
  }
  const auto metres = read_vtp(file("a.vtp"));
  ASSERT_TRUE(metres) << metres.error().message();
  EXPECT_EQ(metres->points[3], Eigen::Vector3f(0, 0, 2));
}

TEST_F(MeshFile, VtpIsReadByVtk) {
  ASSERT_TRUE(write_vtp(file("a.vtp"), tetrahedron));
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file("a.vtp").c_str());
  reader->Update();
  vtkPolyData& read = *reader->GetOutput();
  ASSERT_EQ(read.GetNumberOfPoints(), 4);
  ASSERT_EQ(read.GetNumberOfPolys(), 4);
  EXPECT_EQ(read.GetPoint(3)[2], 2);
  EXPECT_EQ(read.GetCell(3)->GetPointId(2), 3);
  EXPECT_EQ(vtkStringArray::SafeDownCast(read.GetFieldData()->GetAbstractArray("part"))->GetValue(0), "head");
}

TEST_F(MeshFile, VtpIsReadBack) {
  ASSERT_TRUE(write_vtp(file("a.vtp"), tetrahedron));
  const auto read = read_vtp(file("a.vtp"));
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->name, tetrahedron.name);
  EXPECT_EQ(read->points, tetrahedron.points);
  EXPECT_EQ(read->triangles, tetrahedron.triangles);
  std::filesystem::resize_file(file("a.vtp"), 200);
  EXPECT_FALSE(read_vtp(file("a.vtp")));
  EXPECT_FALSE(read_vtp(file("none.vtp")));
}

TEST_F(MeshFile, WritesOneFilePerPartAndFormat) {
  Mesh other = tetrahedron;
  other.name = "lung/left";
  const auto files = write_meshes(folder_ / "mesh", {tetrahedron, other}, {.stl = true, .vtp = false});
  ASSERT_TRUE(files) << files.error().message();
  EXPECT_EQ(*files,
            (std::vector<std::filesystem::path>{folder_ / "mesh/head.stl", folder_ / "mesh/lung_left.stl"}));
  for (const auto& path : *files) EXPECT_EQ(std::filesystem::file_size(path), 284u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "mesh"), {}), 2)
      << "nothing else is left there";
  other.name = "head";
  EXPECT_FALSE(write_meshes(folder_ / "mesh", {tetrahedron, other}));
}

TEST_F(MeshFile, NamesAnObstacle) {
  EXPECT_NE(write_stl(file("no/a.stl"), tetrahedron).error().message().find("No such file"),
            std::string::npos);
  EXPECT_NE(write_vtp(file("no/a.vtp"), tetrahedron).error().message().find("cannot be written"),
            std::string::npos);
  std::filesystem::create_symlink("/dev/full", file("full.stl"));
  std::filesystem::create_symlink("/dev/full", file("full.vtp"));
  EXPECT_NE(write_stl(file("full.stl"), tetrahedron).error().message().find("No space left"),
            std::string::npos);
  EXPECT_FALSE(write_vtp(file("full.vtp"), tetrahedron));
}

}  // namespace
}  // namespace borelli
