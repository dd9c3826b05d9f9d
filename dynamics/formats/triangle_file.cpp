#include "dynamics/formats/triangle_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>

#include "error/file_ending.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

void add_triangle(ClosedMesh& mesh, const Vector3d* corners) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners, corners + 3);
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// 80 bytes of header, the count, then per triangle a normal, three corners (floats) and two bytes.
Result<ClosedMesh> binary_stl(const std::string& bytes, std::uint32_t count) {
  ClosedMesh mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    float numbers[9];
    std::memcpy(numbers, bytes.data() + 84 + std::size_t{50} * t + 12, sizeof numbers);
    Vector3d corners[3];
    for (int i = 0; i < 9; ++i) corners[i / 3][i % 3] = numbers[i];
    add_triangle(mesh, corners);
  }
  return mesh;
}

Result<ClosedMesh> text_stl(const std::string& text, const std::string& file) {
  ClosedMesh mesh;
  std::istringstream lines(text);
  Vector3d corners[3];
  int number = 0, corner = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "outer") corner = 0;
    if (word != "vertex") continue;
    if (corner == 3 || !(words >> corners[corner][0] >> corners[corner][1] >> corners[corner][2]))
      return bad_use(fmt::format("{}:{}", file, number),
                     "expected three vertices of three numbers per facet");
    if (++corner == 3) add_triangle(mesh, corners);
  }
  return mesh;
}

Result<ClosedMesh> stl(const std::string& bytes, const std::string& file) {
  std::uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, sizeof count);
  if (bytes.size() >= 84 && bytes.size() == 84 + std::size_t{50} * count) return binary_stl(bytes, count);
  if (bytes.starts_with("solid") && bytes.find("endsolid") != std::string::npos) return text_stl(bytes, file);
  return bad_use(file, bytes.size() < 84 ? "is too short for an STL file"
                                         : fmt::format("has {} bytes, expected {} for its {} triangles",
                                                       bytes.size(), 84 + std::size_t{50} * count, count));
}

Result<ClosedMesh> obj(const std::string& text, const std::string& file) {
  ClosedMesh mesh;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const auto where = [&] { return fmt::format("{}:{}", file, number); };
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Vector3d p;
      if (!(words >> p[0] >> p[1] >> p[2])) return bad_use(where(), "a vertex needs three numbers");
      mesh.vertices.push_back(p);
    } else if (word == "f") {
      std::vector<int> corners;
      while (words >> word) {  // "7", "7/1", "7//3", "-1": the vertex stands before the first slash
        int index = 0;
        if (!(std::istringstream(word.substr(0, word.find('/'))) >> index))
          return bad_use(where(), fmt::format("'{}' is not a corner of a face", word));
        const int count = static_cast<int>(mesh.vertices.size());
        corners.push_back(index < 0 ? count + index : index - 1);
        if (corners.back() < 0 || corners.back() >= count)
          return bad_use(
              where(), fmt::format("the face refers to vertex {}, but only {} come before it", index, count));
      }
      if (corners.size() < 3) return bad_use(where(), "a face needs at least three corners");
      if (corners.size() == 4) {  // along the shorter diagonal, which lies inside most non-convex ones too
        const auto far = [&](int i, int j) {
          return (mesh.vertices[corners[i]] - mesh.vertices[corners[j]]).norm();
        };
        if (far(1, 3) < far(0, 2)) std::rotate(corners.begin(), corners.begin() + 1, corners.end());
      }
      for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return mesh;
}

// Four counts (vertices, normals, texture coordinates, triangles), then their data: floats, floats, floats,
// ints.
Result<ClosedMesh> msh(const std::string& bytes, const std::string& file) {
  std::int32_t counts[4] = {};
  if (bytes.starts_with("$MeshFormat"))
    return bad_use(file, "is a Gmsh mesh, expected MuJoCo's binary .msh; save it as .stl or .obj");
  if (bytes.size() < sizeof counts) return bad_use(file, "is too short for an .msh file");
  std::memcpy(counts, bytes.data(), sizeof counts);
  const auto [points, normals, textures, triangles] = counts;
  for (const std::int32_t count : counts)
    if (count < 0) return bad_use(file, fmt::format("has a negative count ({}) in its header", count));
  const std::size_t expected = sizeof counts + 12 * std::size_t(points) + 12 * std::size_t(normals) +
                               8 * std::size_t(textures) + 12 * std::size_t(triangles);
  if (bytes.size() != expected)
    return bad_use(file, fmt::format("has {} bytes, expected {} for its {} vertices and {} triangles",
                                     bytes.size(), expected, points, triangles));
  ClosedMesh mesh;
  const char* at = bytes.data() + sizeof counts;
  for (std::int32_t i = 0; i < points; ++i, at += 12) {
    float p[3];
    std::memcpy(p, at, sizeof p);
    mesh.vertices.emplace_back(p[0], p[1], p[2]);
  }
  at += 12 * std::size_t(normals) + 8 * std::size_t(textures);
  for (std::int32_t i = 0; i < triangles; ++i, at += 12) {
    std::int32_t corners[3];
    std::memcpy(corners, at, sizeof corners);
    for (const std::int32_t c : corners)
      if (c < 0 || c >= points)
        return bad_use(file, fmt::format("triangle {} refers to vertex {}; vertices run from 0 to {}", i, c,
                                         points - 1));
    mesh.triangles.push_back({corners[0], corners[1], corners[2]});
  }
  return mesh;
}

}  // namespace

Result<ClosedMesh> read_triangles(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  if (ending != ".stl" && ending != ".obj" && ending != ".msh")
    return bad_use(path.string(), fmt::format("ends in '{}', expected a mesh in .stl, .obj or .msh", ending));
  const auto bytes = read_input_file(path, any_size);
  if (!bytes) return tl::unexpected(bytes.error());
  auto mesh = ending == ".stl"   ? stl(*bytes, path.string())
              : ending == ".obj" ? obj(*bytes, path.string())
                                 : msh(*bytes, path.string());
  if (mesh && mesh->triangles.empty() && (ending == ".stl" || mesh->vertices.empty()))
    return bad_use(path.string(), "contains no triangles");
  if (mesh)
    for (const Vector3d& p : mesh->vertices)
      if (!p.allFinite()) return bad_use(path.string(), "contains a vertex that is not finite");
  return mesh;
}

}  // namespace borelli
