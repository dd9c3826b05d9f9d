// Draws the frames of a film: meshes that move, a floor, arrows, a caption.
#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkLight.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "pipeline/on_demand/vtk/functions.hpp"
#include "pipeline/on_demand/vtk/headless_window.hpp"

namespace borelli::by_vtk {
namespace {

using Eigen::Vector3d;

vtkNew<vtkMatrix4x4> matrix_of(const Pose& X) {
  vtkNew<vtkMatrix4x4> out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out->SetElement(i, j, X.R(i, j));
    out->SetElement(i, 3, X.p[i]);
  }
  return out;
}

/// Edges between triangles that are not in one plane, and those of one triangle alone.
vtkNew<vtkCellArray> edges_of(const Mesh& mesh) {
  constexpr double flat = 0.9999;  // cosine of 0.8 degrees
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Vector3d>> normals;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.points[t[0]].cast<double>(), b = mesh.points[t[1]].cast<double>(),
                   c = mesh.points[t[2]].cast<double>();
    const Vector3d normal = (b - a).cross(c - a).stableNormalized();
    for (std::size_t e = 0; e < 3; ++e) normals[std::minmax(t[e], t[(e + 1) % 3])].push_back(normal);
  }
  vtkNew<vtkCellArray> lines;
  for (const auto& [ends, of] : normals) {
    if (of.size() == 2 && of[0].dot(of[1]) > flat) continue;
    const vtkIdType ids[2] = {ends.first, ends.second};
    lines->InsertNextCell(2, ids);
  }
  return lines;
}

/// One mesh of the film.
class Performer {
 public:
  Performer(const Mesh& mesh, const Colour& colour, FilmStyle style, vtkRenderer& stage) {
    points_->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
    for (std::size_t n = 0; n < mesh.points.size(); ++n)
      points_->SetPoint(static_cast<vtkIdType>(n), mesh.points[n].cast<double>().eval().data());
    vtkNew<vtkCellArray> triangles;
    for (const auto& t : mesh.triangles) {
      const vtkIdType ids[3] = {t[0], t[1], t[2]};
      triangles->InsertNextCell(3, ids);
    }
    surface_->SetPoints(points_);
    surface_->SetPolys(triangles);
    if (style == FilmStyle::wire)
      show_lines(mesh, stage);
    else
      show_surface(colour, stage);
  }

  void place(const Pose& X) const {
    const auto matrix = matrix_of(X);
    for (vtkActor* actor : actors_) actor->SetUserMatrix(matrix);
  }
  void bend(const std::vector<Vector3d>& to) {
    for (std::size_t n = 0; n < to.size(); ++n) points_->SetPoint(static_cast<vtkIdType>(n), to[n].data());
    points_->Modified();
    surface_->Modified();
  }

 private:
  vtkActor* add(vtkPolyDataMapper* mapper, vtkRenderer& stage) {
    mapper->ScalarVisibilityOff();
    actors_.push_back(vtkSmartPointer<vtkActor>::New());
    actors_.back()->SetMapper(mapper);
    stage.AddActor(actors_.back());
    return actors_.back();
  }
  void show_surface(const Colour& colour, vtkRenderer& stage) {
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(surface_);
    normals->ConsistencyOff();
    normals->SetFeatureAngle(50);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(normals->GetOutputPort());
    vtkProperty* const surface = add(mapper, stage)->GetProperty();
    surface->SetColor(colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
    surface->SetSpecular(0.12);
    surface->SetSpecularPower(18);
    surface->SetAmbient(0.18);
  }
  // white surfaces a little behind their black edges hide the edges behind them
  void show_lines(const Mesh& mesh, vtkRenderer& stage) {
    vtkNew<vtkPolyDataMapper> faces;
    faces->SetInputData(surface_);
    faces->SetResolveCoincidentTopologyToPolygonOffset();
    faces->SetRelativeCoincidentTopologyPolygonOffsetParameters(1.5, 1.5);
    vtkProperty* const white = add(faces, stage)->GetProperty();
    white->SetColor(1, 1, 1);
    white->LightingOff();
    vtkNew<vtkPolyData> edges;
    edges->SetPoints(points_);
    edges->SetLines(edges_of(mesh));
    vtkNew<vtkPolyDataMapper> lines;
    lines->SetInputData(edges);
    vtkProperty* const black = add(lines, stage)->GetProperty();
    black->SetColor(0, 0, 0);
    black->LightingOff();
  }

  vtkNew<vtkPoints> points_;
  vtkNew<vtkPolyData> surface_;
  std::vector<vtkSmartPointer<vtkActor>> actors_;
};

void add_floor(const FilmFloor& floor, FilmStyle style, vtkRenderer& stage) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  const auto add_lines = [&](const Vector3d& step, int count, const Vector3d& along, double length) {
    for (int n = 0; n <= count; ++n) {
      const Vector3d middle = floor.middle + (n - count / 2.0) * step;
      const Vector3d ends[2] = {middle - length / 2 * along, middle + length / 2 * along};
      const vtkIdType ids[2] = {points->InsertNextPoint(ends[0].data()),
                                points->InsertNextPoint(ends[1].data())};
      lines->InsertNextCell(2, ids);
    }
  };
  const double a = floor.square;
  add_lines(a * floor.across, floor.squares_across, floor.along, a * floor.squares_along);
  add_lines(a * floor.along, floor.squares_along, floor.across, a * floor.squares_across);
  vtkNew<vtkPolyData> grid;
  grid->SetPoints(points);
  grid->SetLines(lines);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(grid);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  const double grey = style == FilmStyle::wire ? 0.8 : 0.7;
  actor->GetProperty()->SetColor(grey, grey, grey);
  actor->GetProperty()->LightingOff();
  stage.AddActor(actor);
}

/// Ground forces; as many as a frame has are visible.
class Arrows {
 public:
  void show(const std::vector<FilmArrow>& arrows, vtkRenderer& stage, FilmStyle style) {
    while (actors_.size() < arrows.size()) add(stage, style);
    for (std::size_t n = 0; n < actors_.size(); ++n) {
      actors_[n]->SetVisibility(n < arrows.size());
      if (n >= arrows.size()) continue;
      const Vector3d along = arrows[n].to - arrows[n].from;
      const Eigen::Matrix3d R =
          Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix();
      const auto matrix = matrix_of({along.norm() * R, arrows[n].from});
      actors_[n]->SetUserMatrix(matrix);
    }
  }

 private:
  void add(vtkRenderer& stage, FilmStyle style) {
    vtkNew<vtkArrowSource> arrow;
    arrow->SetShaftRadius(0.012);
    arrow->SetTipRadius(0.035);
    arrow->SetTipLength(0.12);
    arrow->SetTipResolution(24);
    arrow->SetShaftResolution(16);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(arrow->GetOutputPort());
    actors_.push_back(vtkSmartPointer<vtkActor>::New());
    actors_.back()->SetMapper(mapper);
    if (style == FilmStyle::wire)
      actors_.back()->GetProperty()->SetColor(0, 0, 0);
    else
      actors_.back()->GetProperty()->SetColor(0.85, 0.12, 0.1);
    stage.AddActor(actors_.back());
  }
  std::vector<vtkSmartPointer<vtkActor>> actors_;
};

void set_stage(const FilmSet& set, vtkRenderer& stage) {
  const bool wire = set.style == FilmStyle::wire;
  stage.SetBackground(wire ? 1 : 0.91, wire ? 1 : 0.925, wire ? 1 : 0.94);
  stage.SetBackground2(1, 1, 1);
  stage.SetGradientBackground(!wire);
  stage.AutomaticLightCreationOff();
  for (const auto& [x, y, z, intensity] :
       {std::array{-0.6, 0.9, 1.0, 0.75}, {0.9, 0.1, 0.7, 0.35}, {0.0, -0.6, 0.8, 0.12}}) {
    vtkNew<vtkLight> light;
    light->SetLightTypeToCameraLight();
    light->SetPosition(x, y, z);
    light->SetFocalPoint(0, 0, 0);
    light->SetIntensity(intensity);
    stage.AddLight(light);
  }
  const Vector3d eye = set.camera.middle + 20 * set.camera.half_height * set.camera.from;
  vtkCamera* const camera = stage.GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(set.camera.middle.data());
  camera->SetPosition(eye.data());
  camera->SetViewUp(set.camera.up.data());
  camera->SetParallelScale(set.camera.half_height);
  camera->SetClippingRange(set.camera.half_height, 40 * set.camera.half_height);
}

}  // namespace

Result<void> draw_film(const FilmSet& set, std::size_t frames, const FrameMaker& frame,
                       const FrameTaker& take) {
  const auto made = headless_window(set.width, set.height);
  if (!made) return tl::unexpected(made.error());
  vtkGenericOpenGLRenderWindow* const window = *made;
  window->SetMultiSamples(8);
  vtkNew<vtkRenderer> stage;
  set_stage(set, *stage);
  window->AddRenderer(stage);
  vtkNew<vtkRenderer> above;  // arrows and caption are visible through the body
  above->SetLayer(1);
  above->SetActiveCamera(stage->GetActiveCamera());
  window->SetNumberOfLayers(2);
  window->AddRenderer(above);
  std::vector<std::unique_ptr<Performer>> performers;
  for (std::size_t m = 0; m < set.meshes.size(); ++m)
    performers.push_back(std::make_unique<Performer>(set.meshes[m], set.colours[m], set.style, *stage));
  if (set.floor) add_floor(*set.floor, set.style, *stage);
  Arrows arrows;
  vtkNew<vtkTextActor> caption;
  caption->GetTextProperty()->SetFontSize(std::max(12, set.height / 30));
  caption->GetTextProperty()->SetColor(0.25, 0.25, 0.28);
  caption->SetPosition(set.height / 36.0, set.height / 36.0);
  above->AddActor2D(caption);
  vtkNew<vtkUnsignedCharArray> pixels;
  for (std::size_t n = 0; n < frames; ++n) {
    const FilmFrame now = frame(n);
    for (std::size_t m = 0; m < performers.size(); ++m) performers[m]->place(now.X_WM[m]);
    if (!now.skin.empty()) performers.front()->bend(now.skin);
    arrows.show(now.arrows, *above, set.style);
    caption->SetInput(now.caption.c_str());
    window->Render();
    window->GetPixelData(0, 0, set.width - 1, set.height - 1, 0, pixels.Get(), 0);
    const auto count = static_cast<std::size_t>(pixels->GetNumberOfValues());
    if (auto taken = take({pixels->GetPointer(0), count}); !taken) return taken;
  }
  return {};
}

}  // namespace borelli::by_vtk
