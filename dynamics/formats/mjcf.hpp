// MJCF, the model language of MuJoCo (mujoco.readthedocs.io/en/stable/XMLreference.html), as a scene.
#pragma once

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// The model is put together (formats/mjcf_assemble.hpp), then each body becomes a solid, in the order of the
/// file, which is MuJoCo's: so the scene's coordinates are qpos, qvel and qfrc_applied, in their order and
/// convention (mjcf_joint.hpp). Inertia comes from <inertial> or the geoms (mjcf_inertia.hpp), springs,
/// dampers and armatures from the joints, constraints from <equality> (mjcf_equality.hpp) and from geoms that
/// touch (mjcf_contact.hpp), gravity and the step from <option>; with contacts the method is `moreau`. Other
/// contacts, actuators, tendons, sensors, fluid and all else that the file holds are listed. Throws
/// XmlRefusal.
ModelFile read_mjcf(XmlElement root);

}  // namespace borelli
