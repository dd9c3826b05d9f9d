// Reads and writes VTK's PolyData as XML.
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "pipeline/on_demand/vtk/functions.hpp"

namespace borelli::by_vtk {
namespace {

void add_text(vtkPolyData& surface, const char* name, const std::string& text) {
  vtkNew<vtkStringArray> array;
  array->SetName(name);
  array->InsertNextValue(text);
  surface.GetFieldData()->AddArray(array);
}

// one value for all triangles
template <class Array>
void add_cell_array(vtkPolyData& surface, const char* name, double value) {
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfTuples(surface.GetNumberOfPolys());
  array->FillComponent(0, value);
  surface.GetCellData()->AddArray(array);
}

}  // namespace

Result<void> write_vtp(const std::string& path, const Mesh& mesh, double per_metre) {
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t n = 0; n < mesh.points.size(); ++n) {
    const Eigen::Vector3d p = per_metre * mesh.points[n].cast<double>();
    points->SetPoint(static_cast<vtkIdType>(n), p.data());
  }
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : mesh.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    triangles->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(triangles);
  add_text(*surface, "part", mesh.name);
  add_text(*surface, "unit", per_metre == 1 ? "m" : "mm");
  add_text(*surface, "SPACE", "LPS");
  if (mesh.label > 0) add_cell_array<vtkUnsignedCharArray>(*surface, "label", mesh.label);
  if (mesh.density) add_cell_array<vtkFloatArray>(*surface, "density", *mesh.density);

  // VTK would print its own messages
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

Result<Mesh> read_vtp(const std::string& path) {
  const int warnings = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkObject::SetGlobalWarningDisplay(warnings);
  vtkPolyData* surface = reader->GetOutput();
  const auto text = [&](const char* name) {
    return surface ? vtkStringArray::SafeDownCast(surface->GetFieldData()->GetAbstractArray(name)) : nullptr;
  };
  auto *part = text("part"), *unit = text("unit");
  if (reader->GetErrorCode() != vtkErrorCode::NoError || !part || part->GetNumberOfValues() != 1)
    return failure(path, "is not a part's mesh as this program writes it, or is damaged");
  Mesh mesh;
  mesh.name = part->GetValue(0);
  const bool in_millimetres = unit && unit->GetNumberOfValues() == 1 && unit->GetValue(0) == "mm";
  const double metres = in_millimetres ? 1e-3 : 1;
  for (vtkIdType n = 0; n < surface->GetNumberOfPoints(); ++n)
    mesh.points.push_back((metres * Eigen::Map<const Eigen::Vector3d>(surface->GetPoint(n))).cast<float>());
  const auto cells = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    cells->GetCurrentCell(count, ids);
    if (count != 3) return failure(path, "contains a face that is not a triangle");
    if (std::any_of(ids, ids + 3, [&](vtkIdType id) { return id < 0 || id >= std::ssize(mesh.points); }))
      return failure(path, "contains a face whose corner is not one of its points");
    mesh.triangles.push_back({static_cast<std::uint32_t>(ids[0]), static_cast<std::uint32_t>(ids[1]),
                              static_cast<std::uint32_t>(ids[2])});
  }
  return mesh;
}

}  // namespace borelli::by_vtk
