// MJCF's contacts: of spheres, capsules, boxes, cylinders, ellipsoids and hulls of meshes, over each other
// and over planes.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/contacts/pass_through.hpp"
#include "dynamics/formats/mjcf_geom.hpp"
#include "dynamics/formats/unique_names.hpp"

namespace borelli {

/// Which geoms may touch, and with what friction, follows MuJoCo (its documentation: Computation, Collision,
/// Selection; Contact parameters). A <pair> names two geoms. Any other two may touch if all of these hold:
/// - The contype of one and the conaffinity of the other share a bit.
/// - Their bodies are not welded to each other, nor parent and child (unless the parent is static).
/// - No <exclude> names the two bodies.
/// Friction and condim are the larger of both, or those of the geom of higher priority. condim 1 means no
/// friction. With <flag override="enable"/> all contacts have the friction of <option>. Restitution is zero.
class MjcfContacts {
 public:
  /// Reads <contact> and the contact settings of <option>.
  explicit MjcfContacts(const XmlElement& root);

  /// What contact selection needs of a body.
  struct Body {
    std::string name;         ///< in the file
    std::string solid;        ///< its solid, or "world"
    std::string weld;         ///< the body with the joint that moves it, or "world"
    std::string weld_parent;  ///< the weld of weld's parent
  };
  /// Adds a geom. Refuses a plane that moves.
  void add(const XmlElement& element, const MjcfGeom& geom, const Body& body);

  struct Found {
    std::vector<Constraint> contacts;
    TouchablePairs without;                     ///< that have no constraint
    std::size_t crowded = 0;                    ///< how many of these are left out as too many
    std::pair<std::string, std::string> first;  ///< the first pair of `without` that is not modelled
    int twisting = 0;  ///< contact pairs with torsional or rolling friction (condim 4 or 6), not modelled
    int directed = 0;  ///< contact pairs whose sliding friction differs by direction, not modelled
  };
  /// Finds all contacts. Names of constraints differ from those in `names`. Contacts of convex shapes with
  /// each other are left out if the rows of all contacts, or these rows times `freedoms`, exceed a limit.
  /// Contacts of spheres and capsules are left out if their own rows times `freedoms` do. Refuses a <pair> of
  /// unknown geoms, and more pairs than memory has room for.
  Found find(UniqueNames names, double freedoms) const;

 private:
  enum class Extent { none, plane, rounded, convex };
  struct Surface {
    // asked for every pair, so in one line of the cache
    int weld = 0, weld_parent = 0;  // numbers of the body's welds; 0: the world
    unsigned type = 1, affinity = 1;
    Extent extent = Extent::none;
    std::string name;  // in the file
    Body body;
    MjcfGeom geom;
    int priority = 0, dimensions = 3;
    double friction = 1;
    bool still() const { return weld == 0; }
    std::string words() const;
  };
  struct Rubbing {
    double friction = 1;
    int dimensions = 3;
    bool directed = false;  // the second direction has another friction
  };
  static Rubbing rubbing_of(const XmlElement& element, const char* friction);
  using Names = std::pair<std::string, std::string>;

  /// Kinds of contacts that are too many to be solved, and the number of pairs that get no contact.
  struct LeftOut {
    bool rounded = false, convex = false;
    std::size_t pairs = 0;
  };
  enum class Modelled { not_at_all, over_plane, rounded, convex };
  static Modelled modelled(const Surface& a, const Surface& b);
  int number_of(const std::string& weld);
  std::vector<const Surface*> touching() const;
  /// Refuses more pairs than memory has room for.
  LeftOut left_out(const std::vector<const Surface*>& surfaces, double freedoms) const;
  const Rubbing* pair_of(const Surface& a, const Surface& b) const;
  bool may_touch(const Surface& a, const Surface& b) const;
  Rubbing between(const Surface& a, const Surface& b) const;
  static std::vector<ConstraintKind> over_plane(const Surface& over, const Plane& plane,
                                                const ContactSurface& rubs);

  const XmlElement& root_;
  std::vector<Surface> surfaces_;
  std::map<std::string, int> welds_{{world_name, 0}};
  std::set<Names> excluded_;         // bodies, in either order
  std::map<Names, Rubbing> paired_;  // geoms, in either order
  std::vector<const XmlElement*> pairs_;
  std::optional<Rubbing> override_;  // friction of all contacts
  bool any_ = true, parents_ = false;
};

}  // namespace borelli
