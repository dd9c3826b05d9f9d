// Meshes as files: STL for tools that take triangles, VTP for those that read VTK.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/export/mesh.hpp"

namespace borelli {

/// Binary STL, coordinates in metres (the format has no unit; the header's text says it). Errors: not
/// writable, disk full.
Result<void> write_stl(const std::string& path, const Mesh& mesh);

/// VTK's PolyData as XML, compressed; metres; the part's name as field data "part". Errors: not writable,
/// disk full.
Result<void> write_vtp(const std::string& path, const Mesh& mesh);

/// Reads such a file back. Errors: missing, damaged, or not made of triangles.
Result<Mesh> read_vtp(const std::string& path);

struct MeshFormats {
  bool stl = true, vtp = true;
};

/// Writes each mesh into `folder` (made where missing) as <name>.stl and <name>.vtp, whole or not at all;
/// what a file's name cannot hold becomes an underscore. Answers the files. Errors: as the writers; two
/// meshes of one file name.
Result<std::vector<std::filesystem::path>> write_meshes(const std::filesystem::path& folder,
                                                        const std::vector<Mesh>& meshes,
                                                        const MeshFormats& formats = {});

}  // namespace borelli
