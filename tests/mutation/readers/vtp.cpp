// Meshes of parts that a run reads back.
#include "pipeline/export/mesh_file.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_vtp {

std::vector<TestCase> seeds() {
  const Mesh tetrahedron{"thigh_left",
                         {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}, {0, 0, 0.1F}},
                         {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  return {
      {"tetrahedron",
       {{"a.vtp", written("a.vtp", [&](const std::string& path) { return write_vtp(path, tetrahedron); })}}}};
}

Result<void> read(const std::filesystem::path& file) {
  const auto mesh = read_vtp(file.string());
  if (!mesh) return tl::unexpected(mesh.error());
  for (const auto& triangle : mesh->triangles)
    for (const auto corner : triangle)
      if (corner >= mesh->points.size()) return defect("a triangle names a vertex that does not exist");
  return {};
}

}  // namespace of_vtp

Reader vtp_reader() { return {"vtp", of_vtp::seeds, of_vtp::read}; }

}  // namespace borelli::mutation
