// Triangles from mesh files: STL (binary and text) and OBJ (vertices and faces; other lines are passed over).
#pragma once

#include <filesystem>

#include "dynamics/shape.hpp"
#include "error/error.hpp"

namespace borelli {

/// The vertices and triangles of an .stl or .obj file, in the file's own unit and order; a face of four
/// corners is cut along its shorter diagonal, one of more into a fan. Only the indices are checked, not
/// whether the triangles close. Errors name file and line.
Result<ClosedMesh> read_triangles(const std::filesystem::path& path);

}  // namespace borelli
