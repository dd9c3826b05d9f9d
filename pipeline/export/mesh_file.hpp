// Writes and reads meshes: STL, PLY and OBJ for tools that take triangles, VTP for tools that read VTK.
//
// Coordinates are the patient's (LPS), as the text "SPACE=LPS" in the files tells 3D Slicer.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/export/mesh.hpp"

namespace borelli {

/// The unit of a file's coordinates. None of the formats states it for programs: 3D Slicer takes mm, Blender
/// m.
enum class MeshUnit { metre, millimetre };

/// Each writes one mesh. Errors: not writable, disk full.
/// Binary STL; the header names part and unit.
Result<void> write_stl(const std::string& path, const Mesh& mesh, MeshUnit unit = MeshUnit::metre);
/// PLY, binary, with shared points; comments name part and unit.
Result<void> write_ply(const std::string& path, const Mesh& mesh, MeshUnit unit = MeshUnit::metre);
/// Wavefront OBJ, one object; comments name part and unit.
Result<void> write_obj(const std::string& path, const Mesh& mesh, MeshUnit unit = MeshUnit::metre);
/// VTK's PolyData as XML. Field data: "part", its name, and "unit". Cell data: "label", and "density"
/// (kg/m^3) if it is known.
Result<void> write_vtp(const std::string& path, const Mesh& mesh, MeshUnit unit = MeshUnit::metre);

/// Reads a file of write_vtp in metres. Errors: missing, damaged, or not made of triangles.
Result<Mesh> read_vtp(const std::string& path);

struct MeshFormats {
  bool stl = true, vtp = true, ply = false, obj = false;
  MeshUnit unit = MeshUnit::metre;
};

/// Writes each mesh into `folder` (created if missing) as <name>.stl, <name>.vtp ..., whole or not at all.
/// Characters that a file name cannot hold become underscores. Returns the files. Errors: as the writers; two
/// meshes of one file name.
Result<std::vector<std::filesystem::path>> write_meshes(const std::filesystem::path& folder,
                                                        const std::vector<Mesh>& meshes,
                                                        const MeshFormats& formats = {});

}  // namespace borelli
