// Draws the body's parts in colour, from the front and from the left.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/export/mesh.hpp"

namespace borelli {

struct PictureOptions {
  int height = 1400;                    ///< pixels; the width follows from the body
  std::vector<Eigen::Vector3d> joints;  ///< centres p_WJ, m: small dark balls, visible through the body
};

/// Whether pictures can be drawn. They need no display, but OpenGL of Mesa through EGL. Errors: in one
/// sentence, what to install.
Result<void> can_draw();

/// Draws meshes of body parts (world frame: x to the Left, y to Posterior, z up) and writes a PNG to `path`.
/// Parts have their colours of palette.hpp; other names get colours of their own. Errors: those of
/// can_draw, path not writable, nothing to draw.
Result<void> draw_body(const std::string& path, const std::vector<Mesh>& meshes,
                       const PictureOptions& options = {});

}  // namespace borelli
