#include "pipeline/mesh_file.hpp"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <system_error>

#include "pipeline/whole_file.hpp"
#include "process/child.hpp"
#include "process/input_file.hpp"

namespace borelli {

// 80 bytes of text, the number of triangles, then per triangle normal, three points and two unused bytes
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
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t n = 0; n < mesh.points.size(); ++n) {
    const Eigen::Vector3d p = mesh.points[n].cast<double>();
    points->SetPoint(static_cast<vtkIdType>(n), p.data());
  }
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : mesh.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    triangles->InsertNextCell(3, ids);
  }
  vtkNew<vtkStringArray> part;
  part->SetName("part");
  part->InsertNextValue(mesh.name);
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(triangles);
  surface->GetFieldData()->AddArray(part);

  // VTK would print its own words
  const int warnings = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputData(surface);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  errno = 0;
  const bool written = writer->Write() == 1 && writer->GetErrorCode() == vtkErrorCode::NoError;
  const int reason = errno;
  vtkObject::SetGlobalWarningDisplay(warnings);
  if (!written) {
    return failure(path,
                   "cannot be written: " +
                       (reason ? std::generic_category().message(reason)
                               : std::string(vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode()))));
  }
  return {};
}

namespace {

Result<Mesh> parsed_vtp(const std::string& path) {
  const int warnings = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkObject::SetGlobalWarningDisplay(warnings);
  vtkPolyData* surface = reader->GetOutput();
  auto* part =
      surface ? vtkStringArray::SafeDownCast(surface->GetFieldData()->GetAbstractArray("part")) : nullptr;
  if (reader->GetErrorCode() != vtkErrorCode::NoError || !part || part->GetNumberOfValues() != 1)
    return failure(path, "is no part's mesh as this program writes it, or is damaged");
  Mesh mesh;
  mesh.name = part->GetValue(0);
  for (vtkIdType n = 0; n < surface->GetNumberOfPoints(); ++n)
    mesh.points.push_back(Eigen::Map<const Eigen::Vector3d>(surface->GetPoint(n)).cast<float>());
  const auto cells = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    cells->GetCurrentCell(count, ids);
    if (count != 3) return failure(path, "holds a face of other than three corners");
    if (std::any_of(ids, ids + 3, [&](vtkIdType id) { return id < 0 || id >= std::ssize(mesh.points); }))
      return failure(path, "has a face with a corner that is not one of its points");
    mesh.triangles.push_back({static_cast<std::uint32_t>(ids[0]), static_cast<std::uint32_t>(ids[1]),
                              static_cast<std::uint32_t>(ids[2])});
  }
  return mesh;
}

}  // namespace

// Damaged files crash VTK, so a child process reads the file first.
Result<Mesh> read_vtp(const std::string& path) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  const auto attempt = [&]() -> Result<void> {
    if (const auto mesh = parsed_vtp(path); !mesh) return tl::unexpected(mesh.error());
    return {};
  };
  if (auto fine = in_child(path, "is damaged: reading it", {}, attempt); !fine)
    return tl::unexpected(fine.error());
  return parsed_vtp(path);
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
      return failure(folder.string(), "two parts would have one file: '" + file_name(mesh.name) + "'");
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
