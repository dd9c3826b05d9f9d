// Reads MJCF, the model language of MuJoCo (mujoco.readthedocs.io/en/stable/XMLreference.html), as a scene.
#pragma once

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

/// Expands the model (formats/mjcf_assemble.hpp), then turns each body into a solid. Solids keep the order of
/// the file, which is MuJoCo's: so the coordinates are qpos, qvel and qfrc_applied, in their order and
/// convention (mjcf_joint.hpp).
/// - Inertia comes from <inertial> or the geoms (mjcf_inertia.hpp).
/// - Springs, dampers and armatures come from the joints.
/// - Constraints come from <equality> (mjcf_equality.hpp) and from geoms that touch (mjcf_contact.hpp).
/// - Gravity and the step come from <option>. With contacts the method is `moreau`.
/// Other contacts, actuators, tendons, sensors, fluid and all other content are listed as not modelled.
/// Throws XmlRefusal.
ModelFile read_mjcf(XmlElement root);

}  // namespace borelli
