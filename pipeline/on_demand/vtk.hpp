// What VTK does for this program: surfaces, forms, files of meshes, pictures.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/pose.hpp"
#include "dynamics/shape.hpp"
#include "pipeline/decimate.hpp"
#include "pipeline/mesh.hpp"
#include "pipeline/palette.hpp"
#include "pipeline/render.hpp"

namespace borelli {

struct VtkFunctions {
  static constexpr const char* library = "borelli_vtk";

  /// The smoothed surface where an image of `size` voxels passes 127.5, in indices of the image; without
  /// triangles where it passes nowhere. Facing outwards in a right-handed frame.
  TriangleSurface (*smooth_surface)(std::vector<unsigned char>& shares, const std::array<int, 3>& size);
  /// Adds the form's triangles to the mesh, moved by X.
  void (*add_form)(Mesh& mesh, const Pose& X, const Form& form);
  Result<void> (*write_vtp)(const std::string& path, const Mesh& mesh);  ///< mesh_file.hpp
  /// Reads what write_vtp wrote; a damaged file may crash VTK.
  Result<Mesh> (*read_vtp)(const std::string& path);
  /// draw_body (render.hpp), where an X display answers and the meshes are not flat; a colour to each
  Result<void> (*draw_body)(const std::string& path, const std::vector<Mesh>& meshes,
                            const std::vector<Colour>& colours, const PictureOptions& options);
};

}  // namespace borelli
