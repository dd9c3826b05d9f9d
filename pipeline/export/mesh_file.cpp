#include "pipeline/export/mesh_file.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>
#include <tuple>

#include "error/printable.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "process/child.hpp"
#include "process/input_file.hpp"
#include "process/on_demand.hpp"

namespace borelli {

namespace {

static_assert(std::endian::native == std::endian::little, "STL and PLY are written little-endian");

float per_metre(MeshUnit unit) { return unit == MeshUnit::metre ? 1.0F : 1000.0F; }

// what each format's free text says
std::string words_of(const Mesh& mesh, MeshUnit unit) {
  return "borelli " + printable(mesh.name) + (unit == MeshUnit::metre ? ", metres" : ", millimetres") +
         ", SPACE=LPS";
}

void put(std::string& bytes, const void* value, std::size_t size) {
  bytes.append(static_cast<const char*>(value), size);
}

Result<void> write_file(const std::string& path, const std::string& bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) return failure(path, "cannot be written: " + std::generic_category().message(errno));
  return {};
}

}  // namespace

// 80 bytes of text, the number of triangles, then per triangle its normal, three points and two unused bytes
Result<void> write_stl(const std::string& path, const Mesh& mesh, MeshUnit unit) {
  std::string bytes = words_of(mesh, unit);
  bytes.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  put(bytes, &count, 4);
  bytes.reserve(84 + 50 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f a = per_metre(unit) * mesh.points[t[0]], b = per_metre(unit) * mesh.points[t[1]],
                          c = per_metre(unit) * mesh.points[t[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).stableNormalized();
    for (const Eigen::Vector3f* v : {&normal, &a, &b, &c}) put(bytes, v->data(), 12);
    put(bytes, "\0\0", 2);
  }
  return write_file(path, bytes);
}

Result<void> write_ply(const std::string& path, const Mesh& mesh, MeshUnit unit) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      words_of(mesh, unit), mesh.points.size(), mesh.triangles.size());
  for (const Eigen::Vector3f& point : mesh.points) {
    const Eigen::Vector3f p = per_metre(unit) * point;
    put(bytes, p.data(), 12);
  }
  for (const auto& t : mesh.triangles) {
    bytes += '\3';
    put(bytes, t.data(), 12);
  }
  return write_file(path, bytes);
}

Result<void> write_obj(const std::string& path, const Mesh& mesh, MeshUnit unit) {
  std::string text = fmt::format("# {}\no {}\n", words_of(mesh, unit), printable(mesh.name));
  for (const Eigen::Vector3f& point : mesh.points) {
    const Eigen::Vector3f p = per_metre(unit) * point;
    fmt::format_to(std::back_inserter(text), "v {} {} {}\n", p[0], p[1], p[2]);
  }
  for (const auto& t : mesh.triangles)
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return write_file(path, text);
}

Result<void> write_vtp(const std::string& path, const Mesh& mesh, MeshUnit unit) {
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  return (*vtk)->write_vtp(path, mesh, static_cast<double>(per_metre(unit)));
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
    return write_whole(files.back(), [&](const std::filesystem::path& beside) {
      return writer(beside.string(), mesh, formats.unit);
    });
  };
  using Writer = Result<void> (*)(const std::string&, const Mesh&, MeshUnit);
  const std::tuple<bool, const char*, Writer> writers[] = {{formats.stl, ".stl", write_stl},
                                                           {formats.vtp, ".vtp", write_vtp},
                                                           {formats.ply, ".ply", write_ply},
                                                           {formats.obj, ".obj", write_obj}};
  for (const Mesh& mesh : meshes)
    for (const auto& [wanted, ending, writer] : writers)
      if (wanted)
        if (const auto done = write(mesh, ending, writer); !done) return tl::unexpected(done.error());
  return files;
}

}  // namespace borelli
