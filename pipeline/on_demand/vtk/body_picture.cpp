// Draws a body from the front and from the left, off screen.
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkErrorCode.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkWindowToImageFilter.h>

#include <cerrno>
#include <cmath>
#include <system_error>

#include "pipeline/on_demand/vtk/functions.hpp"
#include "pipeline/on_demand/vtk/headless_window.hpp"

namespace borelli::by_vtk {
namespace {

using Eigen::Vector3d;

struct Bounds {
  Vector3d least = Vector3d::Constant(1e300), greatest = -least;

  Vector3d middle() const { return (least + greatest) / 2; }
  Vector3d size() const { return greatest - least; }
};

Bounds bounds_of(const std::vector<Mesh>& meshes) {
  Bounds bounds;
  for (const Mesh& mesh : meshes) {
    for (const auto& p : mesh.points) {
      bounds.least = bounds.least.cwiseMin(p.cast<double>());
      bounds.greatest = bounds.greatest.cwiseMax(p.cast<double>());
    }
  }
  return bounds;
}

vtkSmartPointer<vtkActor> coloured(vtkAlgorithmOutput* surface, const Colour& colour) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(surface);
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
  return actor;
}

vtkSmartPointer<vtkActor> part_actor(const Mesh& mesh, const Colour& colour) {
  vtkNew<vtkPoints> points;
  for (const auto& p : mesh.points) points->InsertNextPoint(p.data());
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : mesh.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    triangles->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(triangles);
  vtkNew<vtkPolyDataNormals> normals;  // smooth shading over the triangles; edges of cut faces stay sharp
  normals->SetInputData(surface);
  normals->ConsistencyOff();
  normals->SetFeatureAngle(50);
  normals->Update();
  auto actor = coloured(normals->GetOutputPort(), colour);
  actor->GetProperty()->SetSpecular(0.12);
  actor->GetProperty()->SetSpecularPower(18);
  actor->GetProperty()->SetAmbient(0.18);
  return actor;
}

vtkSmartPointer<vtkActor> joint_actor(const Vector3d& centre, double radius) {
  vtkNew<vtkSphereSource> ball;
  ball->SetCenter(centre[0], centre[1], centre[2]);
  ball->SetRadius(radius);
  ball->SetThetaResolution(24);
  ball->SetPhiResolution(24);
  return coloured(ball->GetOutputPort(), {0x20, 0x20, 0x20});
}

// One view: the body from one side in parallel projection, in a strip of the window
struct View {
  const char* title;
  Vector3d from;       // direction from the body to the camera
  double left, right;  // strip of the window
};

void aim(vtkRenderer& renderer, const View& view, const Bounds& bounds) {
  const Vector3d middle = bounds.middle(), eye = middle + 3 * bounds.size().norm() * view.from;
  auto* const camera = renderer.GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(middle[0], middle[1], middle[2]);
  camera->SetPosition(eye[0], eye[1], eye[2]);
  camera->SetViewUp(0, 0, 1);
  camera->SetParallelScale(0.54 * bounds.size().z());  // half the height, plus a margin
  renderer.ResetCameraClippingRange();
}

// a key light from above the camera's left shoulder and a fill light from the right, both moving with the
// camera
void light(vtkRenderer& renderer) {
  renderer.AutomaticLightCreationOff();
  const auto add = [&](double x, double y, double z, double intensity) {
    vtkNew<vtkLight> one;
    one->SetLightTypeToCameraLight();
    one->SetPosition(x, y, z);
    one->SetFocalPoint(0, 0, 0);
    one->SetIntensity(intensity);
    renderer.AddLight(one);
  };
  add(-0.6, 0.9, 1, 0.75), add(0.9, 0.1, 0.7, 0.35), add(0, -0.6, 0.8, 0.12);
}

void add_title(vtkRenderer& renderer, const char* title, int height) {
  vtkNew<vtkTextActor> text;
  text->SetInput(title);
  text->GetTextProperty()->SetFontSize(std::max(12, height / 50));
  text->GetTextProperty()->SetColor(0.35, 0.35, 0.38);
  text->GetTextProperty()->SetJustificationToCentered();
  text->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  text->SetPosition(0.5, 0.012);
  renderer.AddActor2D(text);
}

void add_view(vtkRenderWindow& window, const View& view, const std::vector<vtkSmartPointer<vtkActor>>& bodies,
              const std::vector<vtkSmartPointer<vtkActor>>& joints, const Bounds& bounds, int height) {
  vtkNew<vtkRenderer> body;
  body->SetViewport(view.left, 0, view.right, 1);
  body->SetBackground(0.91, 0.925, 0.94);
  body->SetBackground2(1, 1, 1);
  body->GradientBackgroundOn();
  light(*body);
  for (const auto& actor : bodies) body->AddActor(actor);
  window.AddRenderer(body);
  aim(*body, view, bounds);

  vtkNew<vtkRenderer> above;  // a separate layer, so that joints inside the body are visible
  above->SetViewport(view.left, 0, view.right, 1);
  above->SetLayer(1);
  light(*above);
  for (const auto& actor : joints) above->AddActor(actor);
  add_title(*above, view.title, height);
  window.AddRenderer(above);
  above->SetActiveCamera(body->GetActiveCamera());
  above->ResetCameraClippingRange();
}

Result<void> write_png(const std::string& path, vtkRenderWindow& window) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(&window);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  image->Update();
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputConnection(image->GetOutputPort());
  const int warnings = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();  // VTK would print its own messages
  errno = 0;
  writer->Write();
  const int reason = errno;
  vtkObject::SetGlobalWarningDisplay(warnings);
  if (writer->GetErrorCode() != vtkErrorCode::NoError)
    return failure(path, "cannot be written: " + (reason ? std::generic_category().message(reason)
                                                         : std::string("the disk may be full")));
  return {};
}

}  // namespace

Result<void> draw_body(const std::string& path, const std::vector<Mesh>& meshes,
                       const std::vector<Colour>& colours, const PictureOptions& options) {
  const Bounds bounds = bounds_of(meshes);
  std::vector<vtkSmartPointer<vtkActor>> bodies, joints;
  for (std::size_t n = 0; n < meshes.size(); ++n) bodies.push_back(part_actor(meshes[n], colours[n]));
  for (const auto& joint : options.joints) joints.push_back(joint_actor(joint, 0.006 * bounds.size().z()));

  // strips as wide as the body in each view, plus a tenth of its height
  const Vector3d size = bounds.size();
  const double front = size.x() + 0.1 * size.z(), side = size.y() + 0.1 * size.z();
  const double seam = front / (front + side);
  const auto made = headless_window(
      static_cast<int>(std::lround(options.height * (front + side) / (1.08 * size.z()))), options.height);
  if (!made) return failure(path, made.error().what);
  vtkGenericOpenGLRenderWindow* const window = *made;
  window->SetMultiSamples(8);
  window->SetNumberOfLayers(2);
  add_view(*window, {"front", -Vector3d::UnitY(), 0, seam}, bodies, joints, bounds, options.height);
  add_view(*window, {"left side", Vector3d::UnitX(), seam, 1}, bodies, joints, bounds, options.height);
  window->Render();
  return write_png(path, *window);
}

}  // namespace borelli::by_vtk
