// An MJCF document while it is written.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/omissions.hpp"
#include "dynamics/formats/plain_scene.hpp"
#include "dynamics/formats/unique_names.hpp"
#include "dynamics/formats/xml_text.hpp"

namespace borelli {

/// A form at its place in a body, by MJCF's `type` and `size`.
struct MjcfForm {
  const char* type = "";
  Pose X{};
  std::vector<double> size{};

  /// Whether both look the same, within rounding.
  bool looks_like(const MjcfForm& other) const;
};

/// The form at the origin; with an empty type if MJCF has none such.
MjcfForm mjcf_form(const Form& form);

struct MjcfDraft {
  struct Drawn {
    MjcfForm form;
    XmlNode* node;
    std::string name;  ///< empty: none yet
  };

  const PlainScene& plain;
  Omissions& lost;
  XmlNode root{.name = "mujoco"};
  XmlNode asset{.name = "asset"}, world{.name = "worldbody"}, contact{.name = "contact"},
      tendon{.name = "tendon"}, equality{.name = "equality"};
  std::map<std::string, XmlNode*> bodies{};              ///< by solid, with the world
  std::map<std::string, Pose> poses{};                   ///< X_WS in the model's pose (qpos0)
  std::map<std::string, double> refs{};                  ///< `ref` of hinges and slides, by coordinate
  std::map<std::string, bool> still{};                   ///< whether a solid is fixed to the world
  std::map<const XmlNode*, std::vector<Drawn>> drawn{};  ///< geoms by body
  UniqueNames geoms{}, meshes{}, sites{}, solids{};
};

/// `pos` and `quat` of an element; none where they are zero and identity.
void set_place(XmlNode& node, const Pose& X);

/// Adds a geom that weighs nothing and touches only what a <pair> names.
XmlNode& add_geom(MjcfDraft& draft, const std::string& solid, const MjcfForm& form);

/// Adds the shapes of solids, and files of triangles, as geoms that touch nothing and weigh nothing.
void add_mjcf_shapes(MjcfDraft& draft, const std::vector<ModelMesh>& meshes);
/// Adds a contact as a pair of geoms. False: the constraint is no contact.
bool add_mjcf_contact(MjcfDraft& draft, const Constraint& constraint);
/// Adds contacts as pairs of geoms, loops and couplings as equalities. Others are named in `lost`.
void add_mjcf_constraints(MjcfDraft& draft);
/// Adds markers as sites, and springs between points as tendons. Other efforts are named in `lost`.
void add_mjcf_sites(MjcfDraft& draft);

}  // namespace borelli
