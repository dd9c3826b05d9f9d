// An OpenGL window that is never on a screen: pictures without an X display.
#pragma once

#include "error/error.hpp"

template <class T>
class vtkSmartPointer;
class vtkGenericOpenGLRenderWindow;

namespace borelli::by_vtk {

/// A window with a context of its own from EGL's platform without surfaces (EGL_MESA_platform_surfaceless):
/// Mesa draws with the graphics card, or with the processor where there is none. The context is current in
/// this thread; draw in this thread. VTK draws into a framebuffer of its own. Errors: no such platform, or
/// OpenGL older than 3.2.
Result<vtkSmartPointer<vtkGenericOpenGLRenderWindow>> headless_window(int width, int height);

}  // namespace borelli::by_vtk
