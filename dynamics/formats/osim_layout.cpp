#include "dynamics/formats/osim_layout.hpp"

#include <fmt/core.h>

#include <set>

#include "dynamics/scene/site.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

std::vector<const XmlElement*> osim_coordinates(const XmlElement& joint) {
  std::vector<const XmlElement*> out;
  const XmlElement* list = joint.child("coordinates");
  if (const XmlElement* set = joint.child("CoordinateSet")) {
    list = set->child("objects");
    set->child("groups");
  }
  if (!list) return out;
  for (const XmlElement& c : list->children)
    if (c.name == "Coordinate") {
      c.read = true;
      out.push_back(&c);
    }
  return out;
}

// OpenSim 2 and 3: the joint stands in the body that it carries.
OsimJoint old_joint(const XmlElement& joint, const std::string& body, const OsimFrames& frames) {
  const std::string parent = joint.require_child("parent_body").content;
  OsimJoint out{.name = joint.text("name"), .element = &joint, .parent = {}, .child = {}, .coordinates = {}};
  out.parent = {
      frames.find(joint, parent).solid,
      {osim_rotation(osim_vector(joint, "orientation_in_parent")), osim_vector(joint, "location_in_parent")}};
  out.child = {body, {osim_rotation(osim_vector(joint, "orientation")), osim_vector(joint, "location")}};
  out.inverted = osim_flag(joint, "reverse", false);
  out.coordinates = osim_coordinates(joint);
  return out;
}

OsimJoint new_joint(const XmlElement& joint, const OsimFrames& frames) {
  if (joint.name.ends_with("Joint")) joint.child("frames");
  OsimJoint out{.name = joint.text("name"), .element = &joint, .parent = {}, .child = {}, .coordinates = {}};
  out.parent = frames.named_by(joint, {"socket_parent_frame"});
  out.child = frames.named_by(joint, {"socket_child_frame"});
  out.coordinates = osim_coordinates(joint);
  return out;
}

// The joint in an old layout's body; null: none.
const XmlElement* joint_in(const XmlElement& body) {
  const XmlElement* holder = body.child("Joint");
  if (!holder || holder->children.empty()) return nullptr;
  if (holder->children.size() > 1) holder->refuse("contains several joints, expected one");
  holder->children[0].read = true;
  return &holder->children[0];
}

}  // namespace

std::vector<const XmlElement*> osim_objects(const XmlElement& parent, std::string_view set) {
  const XmlElement* element = parent.child(set);
  if (!element) return {};
  element->text("name");
  if (const std::string file = element->text("file"); !file.empty())
    element->refuse("file", fmt::format("its content is in another file, '{}'; open the model in OpenSim and "
                                        "save it, which makes one file",
                                        printable(file)));
  element->child("groups");
  const XmlElement* objects = element->child("objects");
  std::vector<const XmlElement*> out;
  if (!objects) return out;
  for (const XmlElement& c : objects->children) out.push_back(&c);
  return out;
}

std::vector<const XmlElement*> osim_components(const XmlElement& model) {
  std::vector<const XmlElement*> out = osim_objects(model, "ComponentSet");
  if (const XmlElement* components = model.child("components"))
    for (const XmlElement& c : components->children) out.push_back(&c);
  return out;
}

OsimLayout read_osim_layout(const XmlElement& model, const OsimFrames& frames) {
  OsimLayout out;
  std::vector<const XmlElement*> joints = osim_objects(model, "JointSet");
  std::vector<const XmlElement*> bodies = osim_objects(model, "BodySet");
  for (const XmlElement* c : osim_components(model)) {
    if (c->name == "Body") bodies.push_back(c);
    if (c->name.ends_with("Joint")) joints.push_back(c);
  }
  std::set<std::string> names;
  for (const XmlElement* body : bodies) {
    if (body->name != "Body") continue;  // (listed as unread)
    body->read = true;
    body->child("components");  // (its frames are found by their paths)
    const std::string& name = body->require("name");
    const XmlElement* joint = joint_in(*body);
    if (name == "ground") {
      for (const XmlElement& c : body->children)  // the world has no mass
        if (c.name.starts_with("mass") || c.name.starts_with("inertia")) c.read = true;
      continue;
    }
    if (name.empty()) body->refuse("has an empty name; give it a name");
    if (name == world_name) body->refuse("has the fixed frame's name; rename it");
    if (!names.insert(name).second) body->refuse("has the name of another one; rename one of them");
    out.bodies.push_back(body);
    if (joint) out.joints.push_back(old_joint(*joint, name, frames));
  }
  for (const XmlElement* joint : joints) {
    joint->read = true;
    joint->child("components");
    out.joints.push_back(new_joint(*joint, frames));
  }
  return out;
}

}  // namespace borelli
