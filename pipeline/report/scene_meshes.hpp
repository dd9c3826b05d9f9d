// Makes meshes of a scene: the solids' shapes, and substitutes for solids without a shape.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"
#include "pipeline/export/mesh.hpp"

namespace borelli {

/// One mesh per solid, in the solid's own frame and with its name. Then the ground of each contact with the
/// world, as a thin plate in the world frame, named "world: " and the constraint's name.
///
/// A solid without a shape becomes rods from its origin to the points where children, constraints and efforts
/// attach. Without such points it becomes the uniform box with the solid's inertia (a point mass: a small
/// sphere). Round shapes have 32 sides. Errors: an impossible inertia.
Result<std::vector<Mesh>> scene_meshes(const Scene& scene);

/// The scene's motion for 3D viewers (glb.hpp), with one colour per solid.
Result<std::string> scene_glb(const Scene& scene, const Trajectory& trajectory);

/// The scene's motion as one self-contained page (report.hpp): warnings, player, energies, certificate.
Result<std::string> scene_page(const Scene& scene, const Trajectory& trajectory,
                               const std::vector<std::string>& warnings = {});

}  // namespace borelli
