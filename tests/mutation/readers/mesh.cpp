// Meshes of models: STL in both forms, OBJ, MuJoCo's .msh.
#include "dynamics/formats/triangle_file.hpp"
#include "tests/mutation/dicom_bytes.hpp"
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_mesh {

const std::string text =
    "solid by hand\n facet normal 0 0 -1\n  outer loop\n   vertex 0 0 0\n   vertex 0 0.1 0\n   vertex 0.1 0 "
    "0\n"
    "  endloop\n endfacet\n facet normal 0 -1 0\n  outer loop\n   vertex 0 0 0\n   vertex 1e-1 0 0\n"
    "   vertex 0 0 .1\n  endloop\n endfacet\nendsolid by hand\n";

const std::string object =
    "# by hand\no tetra\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 1e-1\nvt 0 0\nvn 0 0 1\ns off\n"
    "f 1 3 2\nf 1//1 2//1 4//1\nf 1/1/1 4/1/1 3/1/1\nf -3 -2 -1\n";

// Counts of vertices, normals, texture coordinates and faces; then each of them.
std::string msh() {
  std::string out = little_endian<std::int32_t>(4) + little_endian<std::int32_t>(0) +
                    little_endian<std::int32_t>(0) + little_endian<std::int32_t>(4);
  for (const float x : {0.F, 0.F, 0.F, .1F, 0.F, 0.F, 0.F, .1F, 0.F, 0.F, 0.F, .1F}) out += little_endian(x);
  for (const std::int32_t n : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}) out += little_endian(n);
  return out;
}

Result<void> read(const std::filesystem::path& file) {
  const auto mesh = read_triangles(file);
  if (!mesh) return tl::unexpected(mesh.error());
  for (const auto& triangle : mesh->triangles)
    for (const int corner : triangle)
      if (corner < 0 || corner >= std::ssize(mesh->vertices))
        return defect("a triangle names a vertex that does not exist");
  return {};
}

std::vector<TestCase> seeds() {
  return {{"stl", {{"a.stl", tetrahedron_stl()}}},
          {"stl_text", {{"a.stl", text}}},
          {"obj", {{"a.obj", object}}},
          {"msh", {{"a.msh", msh()}}, true}};
}

}  // namespace of_mesh

Reader mesh_reader() { return {"mesh", of_mesh::seeds, of_mesh::read}; }

}  // namespace borelli::mutation
