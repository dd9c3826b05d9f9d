#include "pipeline/export/render.hpp"

#include <algorithm>

#include "pipeline/files/palette.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "process/on_demand.hpp"

namespace borelli {
namespace {

// whether all points lie in one plane normal to a coordinate axis, or there are none
bool flat(const std::vector<Mesh>& meshes) {
  Eigen::Array3f least = Eigen::Array3f::Constant(1e30F), greatest = -least;
  for (const Mesh& mesh : meshes)
    for (const Eigen::Vector3f& p : mesh.points)
      least = least.min(p.array()), greatest = greatest.max(p.array());
  return !(least < greatest).all();
}

}  // namespace

Result<void> can_draw() {
  const auto vtk = on_demand<VtkFunctions>();
  return vtk ? (*vtk)->can_draw() : tl::unexpected(vtk.error());
}

Result<void> draw_body(const std::string& path, const std::vector<Mesh>& meshes,
                       const PictureOptions& options) {
  if (flat(meshes)) return failure(path, "has nothing to show: the meshes are empty");
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  std::vector<Colour> colours;
  for (std::size_t n = 0; n < meshes.size(); ++n) {
    const std::string& name = meshes[n].name;
    colours.push_back(is_segment(name) ? part_colour(name) : other_colour(n));
  }
  return (*vtk)->draw_body(path, meshes, colours, options);
}

}  // namespace borelli
