// What a scene looks like: its solids' shapes as meshes, and stand-ins for solids that have none.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"
#include "pipeline/export/mesh.hpp"

namespace borelli {

/// One mesh per solid, in the solid's own frame and by its name, then the ground of contacts with the world
/// as thin plates in the world frame ("world: " and the constraint's name).
///
/// A solid without a shape is drawn as rods from its origin to where its children, constraints and efforts
/// take hold of it; one that is held nowhere else as the box of even density that has its inertia (a point
/// mass: a small sphere). Round forms are drawn with 32 sides. Errors: an inertia that cannot be.
Result<std::vector<Mesh>> scene_meshes(const Scene& scene);

/// The scene's motion for 3D viewers (glb.hpp), a colour to each solid.
Result<std::string> scene_glb(const Scene& scene, const Trajectory& trajectory);

/// The scene's motion as one page that needs nothing else (report.hpp): player, energies, certificate.
Result<std::string> scene_page(const Scene& scene, const Trajectory& trajectory);

}  // namespace borelli
