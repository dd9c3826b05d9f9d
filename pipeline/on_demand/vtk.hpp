// Functions of the library that calls VTK: surfaces, shapes, mesh files, pictures.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/scene/shape.hpp"
#include "pipeline/export/decimate.hpp"
#include "pipeline/export/mesh.hpp"
#include "pipeline/export/render.hpp"
#include "pipeline/files/palette.hpp"
#include "pipeline/video/film.hpp"

namespace borelli {

struct VtkFunctions {
  static constexpr const char* library = "borelli_vtk";

  /// Smoothed isosurface at 127.5 of an image of `size` voxels, x fastest. Points are voxel indices;
  /// triangles face outwards in a right-handed frame. No triangles if no voxel exceeds 127.5.
  TriangleSurface (*smooth_surface)(std::vector<unsigned char>& shares, const std::array<int, 3>& size);
  /// Appends the triangles of `form`, placed by `X`, to `mesh`.
  void (*add_form)(Mesh& mesh, const Pose& X, const Form& form);
  /// See mesh_file.hpp; `per_metre`: the file's units in a metre. Errors: the file cannot be written.
  Result<void> (*write_vtp)(const std::string& path, const Mesh& mesh, double per_metre);
  /// Reads a file of write_vtp. A damaged file may crash VTK: call it in a child process first. Errors: the
  /// file cannot be read.
  Result<Mesh> (*read_vtp)(const std::string& path);
  /// See draw_body in render.hpp; colours[i] is that of meshes[i]. The meshes must not all be flat.
  Result<void> (*draw_body)(const std::string& path, const std::vector<Mesh>& meshes,
                            const std::vector<Colour>& colours, const PictureOptions& options);
  /// See can_draw in render.hpp.
  Result<void> (*can_draw)();
  /// Draws frames 0 to frames - 1. Errors: as can_draw; those of `take`, which end the film.
  Result<void> (*draw_film)(const FilmSet& set, std::size_t frames, const FrameMaker& frame,
                            const FrameTaker& take);
};

}  // namespace borelli
