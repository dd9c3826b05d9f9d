// Writes and reads meshes: STL for tools that take triangles, VTP for tools that read VTK.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/export/mesh.hpp"

namespace borelli {

/// Binary STL, coordinates in metres (the format has no unit; the header's text states it). Errors: not
/// writable, disk full.
Result<void> write_stl(const std::string& path, const Mesh& mesh);

/// VTK's PolyData as XML, compressed; metres; the part's name as field data "part". Errors: not writable,
/// disk full.
Result<void> write_vtp(const std::string& path, const Mesh& mesh);

/// Reads a file of write_vtp. Errors: missing, damaged, or not made of triangles.
Result<Mesh> read_vtp(const std::string& path);

struct MeshFormats {
  bool stl = true, vtp = true;
};

/// Writes each mesh into `folder` (created if missing) as <name>.stl and <name>.vtp, whole or not at all.
/// Characters that a file name cannot hold become underscores. Returns the files. Errors: as the writers; two
/// meshes of one file name.
Result<std::vector<std::filesystem::path>> write_meshes(const std::filesystem::path& folder,
                                                        const std::vector<Mesh>& meshes,
                                                        const MeshFormats& formats = {});

}  // namespace borelli
