#include "pipeline/export/mesh_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <system_error>

#include "pipeline/files/whole_file.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "process/child.hpp"
#include "process/input_file.hpp"
#include "process/on_demand.hpp"

namespace borelli {

// 80 bytes of text, the number of triangles, then per triangle its normal, three points and two unused bytes
Result<void> write_stl(const std::string& path, const Mesh& mesh) {
  static_assert(std::endian::native == std::endian::little, "STL is little-endian");
  std::string bytes = "borelli " + mesh.name + ", metres";
  bytes.resize(80, ' ');
  const auto put = [&](const void* value, std::size_t size) {
    bytes.append(static_cast<const char*>(value), size);
  };
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  put(&count, 4);
  bytes.reserve(84 + 50 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).stableNormalized();
    for (const Eigen::Vector3f* v : {&normal, &a, &b, &c}) put(v->data(), 12);
    put("\0\0", 2);
  }
  errno = 0;
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) return failure(path, "cannot be written: " + std::generic_category().message(errno));
  return {};
}

Result<void> write_vtp(const std::string& path, const Mesh& mesh) {
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  return (*vtk)->write_vtp(path, mesh);
}

// Damaged files crash VTK, so a child process reads the file first.
Result<Mesh> read_vtp(const std::string& path) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  const auto attempt = [&]() -> Result<void> {
    if (const auto mesh = (*vtk)->read_vtp(path); !mesh) return tl::unexpected(mesh.error());
    return {};
  };
  if (auto fine = in_child(path, "is damaged: reading it", {}, attempt); !fine)
    return tl::unexpected(fine.error());
  return (*vtk)->read_vtp(path);
}

namespace {

std::string file_name(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.') c = '_';
  if (name.empty() || name.front() == '.') name.insert(name.begin(), '_');
  return name;
}

}  // namespace

Result<std::vector<std::filesystem::path>> write_meshes(const std::filesystem::path& folder,
                                                        const std::vector<Mesh>& meshes,
                                                        const MeshFormats& formats) {
  std::set<std::string> names;
  for (const Mesh& mesh : meshes)
    if (!names.insert(file_name(mesh.name)).second)
      return failure(folder.string(), "two parts would share one file: '" + file_name(mesh.name) + "'");
  std::vector<std::filesystem::path> files;
  const auto write = [&](const Mesh& mesh, const char* ending, auto writer) {
    files.push_back(folder / (file_name(mesh.name) + ending));
    return write_whole(files.back(),
                       [&](const std::filesystem::path& beside) { return writer(beside.string(), mesh); });
  };
  for (const Mesh& mesh : meshes) {
    if (formats.stl)
      if (const auto done = write(mesh, ".stl", write_stl); !done) return tl::unexpected(done.error());
    if (formats.vtp)
      if (const auto done = write(mesh, ".vtp", write_vtp); !done) return tl::unexpected(done.error());
  }
  return files;
}

}  // namespace borelli
