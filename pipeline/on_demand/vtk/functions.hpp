// The functions of the table in on_demand/vtk.hpp, each defined in the file of its name.
#pragma once

#include "pipeline/on_demand/vtk.hpp"

namespace borelli::by_vtk {

TriangleSurface smooth_surface(std::vector<unsigned char>& shares, const std::array<int, 3>& size);
void add_form(Mesh& mesh, const Pose& X, const Form& form);
Result<void> write_vtp(const std::string& path, const Mesh& mesh, double per_metre);
Result<Mesh> read_vtp(const std::string& path);
Result<void> draw_body(const std::string& path, const std::vector<Mesh>& meshes,
                       const std::vector<Colour>& colours, const PictureOptions& options);
Result<void> can_draw();
Result<void> draw_film(const FilmSet& set, std::size_t frames, const FrameMaker& frame,
                       const FrameTaker& take);

}  // namespace borelli::by_vtk
