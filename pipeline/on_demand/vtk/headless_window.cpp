#include "pipeline/on_demand/vtk/headless_window.hpp"

#include "pipeline/on_demand/vtk/functions.hpp"

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glew.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>

namespace borelli::by_vtk {
namespace {

/// EGL's context, current from its making to its end.
class EglContext {
 public:
  EglContext() = default;
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext() {
    if (display_ == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  }

  /// Whether OpenGL 3.2 answers now.
  bool make() {
    const auto display_of =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (display_of == nullptr) return false;
    display_ = display_of(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) == EGL_FALSE ||
        eglBindAPI(EGL_OPENGL_API) == EGL_FALSE)
      return false;
    constexpr std::array<EGLint, 5> any{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                        EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint found = 0;
    if (eglChooseConfig(display_, any.data(), &config, 1, &found) == EGL_FALSE || found == 0) return false;
    constexpr std::array<EGLint, 7> core{EGL_CONTEXT_MAJOR_VERSION,
                                         3,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         2,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, core.data());
    return context_ != EGL_NO_CONTEXT && make_current();
  }
  bool make_current() const {
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  bool is_current() const { return eglGetCurrentContext() == context_; }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

class HeadlessWindow : public vtkGenericOpenGLRenderWindow {
 public:
  static HeadlessWindow* New();

  bool make() { return context_.make(); }

  void MakeCurrent() override { context_.make_current(); }
  bool IsCurrent() override { return context_.is_current(); }
  int SupportsOpenGL() override { return 1; }
  vtkTypeBool IsDirect() override { return 1; }

 protected:
  ~HeadlessWindow() override { Finalize(); }

  // VTK's own asks GLEW for GLX, which needs a display. GLEW has the functions of OpenGL before it asks.
  void OpenGLInitContext() override {
    ContextCreationTime.Modified();
    if (Initialized) return;
    glewExperimental = GL_TRUE;
    const GLenum answer = glewInit();
    GlewInitValid = answer == GLEW_OK || answer == GLEW_ERROR_NO_GLX_DISPLAY;
    if (!GlewInitValid) return;
    std::array<float, 2> widths{1, 1};
    glGetFloatv(GL_LINE_WIDTH_RANGE, widths.data());
    MaximumHardwareLineWidth = std::max(widths[1], 1.0F);
    Initialized = true;
  }

 private:
  EglContext context_;
};

vtkStandardNewMacro(HeadlessWindow);

}  // namespace

Result<vtkSmartPointer<vtkGenericOpenGLRenderWindow>> headless_window(int width, int height) {
  const auto window = vtkSmartPointer<HeadlessWindow>::New();
  if (!window->make())
    return failure("picture",
                   "cannot be drawn: EGL has no OpenGL 3.2 that needs no display; install Mesa's drivers "
                   "(Debian: libegl-mesa0 and libgl1-mesa-dri)");
  window->SetSize(width, height);
  window->SetOffScreenRendering(1);
  return vtkSmartPointer<vtkGenericOpenGLRenderWindow>(window.Get());
}

Result<void> can_draw() {
  const auto window = headless_window(16, 16);
  return window ? Result<void>{} : tl::unexpected(window.error());
}

}  // namespace borelli::by_vtk
