// MJCF's contacts, as far as the scene has constraints for them: spheres and capsules over each other and
// over planes, boxes over planes.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/contacts/pass_through.hpp"
#include "dynamics/formats/mjcf_geom.hpp"
#include "dynamics/formats/unique_names.hpp"

namespace borelli {

/// Which geoms may touch, and with what friction, is as in MuJoCo (its documentation: Computation, Collision,
/// Selection; Contact parameters). A <pair> names two; of others the contype of one and the conaffinity of
/// the other share a bit, their bodies are not welded to each other, nor parent and child (unless the parent
/// stands still), and no <exclude> names the two. Friction and condim are the larger of both, or those of the
/// geom of higher priority; condim 1 is without friction. Restitution is none.
class MjcfContacts {
 public:
  /// Reads <contact> and what <option> says of it.
  explicit MjcfContacts(const XmlElement& root);

  /// A body as contacts see it.
  struct Body {
    std::string name;         ///< in the file
    std::string solid;        ///< or "world"
    std::string weld;         ///< the body that has the joint which moves it, or "world"
    std::string weld_parent;  ///< that of weld's parent
  };
  /// Takes a geom in. Refuses a plane that moves.
  void add(const XmlElement& element, const MjcfGeom& geom, const Body& body);

  struct Found {
    std::vector<Constraint> contacts;
    std::vector<TouchablePair> without;  ///< what may touch, with no constraint for it
    std::size_t crowded = 0;  ///< how many of these are spheres and capsules, more than there is room for
    std::pair<std::string, std::string> first;  ///< the first pair of `without` that no contact is made for
    int twisting = 0;  ///< pairs in contact with friction against turning (condim 4 or 6)
  };
  /// All of them; names of constraints differ from those in `names`. Refuses a <pair> of geoms that are not
  /// there, and more pairs than memory has room for.
  /// Contacts of spheres and capsules with each other are left out where all contacts times `freedoms` are
  /// more than there is room for.
  Found find(UniqueNames names, double freedoms) const;

 private:
  struct Surface {
    std::string name;  // in the file
    Body body;
    MjcfGeom geom;
    unsigned type = 1, affinity = 1;
    int priority = 0, dimensions = 3;
    double friction = 1;
    bool still() const { return body.weld == world_name; }
    std::string words() const;
  };
  struct Rubbing {
    double friction = 1;
    int dimensions = 3;
  };
  using Names = std::pair<std::string, std::string>;

  std::vector<const Surface*> touching(double freedoms, bool& crowded) const;
  const Rubbing* pair_of(const Surface& a, const Surface& b) const;
  bool may_touch(const Surface& a, const Surface& b) const;
  Rubbing between(const Surface& a, const Surface& b) const;
  static std::vector<ConstraintKind> over_plane(const Surface& over, const Plane& plane,
                                                const ContactSurface& rubs);

  const XmlElement& root_;
  std::vector<Surface> surfaces_;
  std::set<Names> excluded_;         // bodies, in either order
  std::map<Names, Rubbing> paired_;  // geoms, in either order
  std::vector<const XmlElement*> pairs_;
  bool any_ = true, parents_ = false;
};

}  // namespace borelli
