// Reads triangles from mesh files: STL (binary and text), OBJ (vertices and faces; other lines are skipped)
// and MuJoCo's own binary .msh.
#pragma once

#include <filesystem>

#include "dynamics/scene/shape.hpp"
#include "error/error.hpp"

namespace borelli {

/// The vertices and triangles of an .stl, .obj or .msh file, in the unit and order of the file. A face of
/// four corners is cut along its shorter diagonal, one of more into a fan. Only the indices are checked, not
/// whether the mesh is closed. An .obj or .msh may hold points alone. Errors name file and line.
Result<ClosedMesh> read_triangles(const std::filesystem::path& path);

}  // namespace borelli
