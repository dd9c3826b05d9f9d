// Resolves, once, the solids and coordinates that the fields of efforts and constraints name.
#pragma once

#include <map>
#include <set>
#include <string>

#include "dynamics/system/system.hpp"

namespace borelli {

/// What compile() knows of a named coordinate.
struct KnownCoordinate {
  int step = -1;  ///< index in System::steps; -1: locked
  int nq = 0;
  double value = 0;                         ///< of a locked scalar
  Quaternion turn = identity_quaternion();  ///< of a locked ball
  std::string solid;
  std::vector<Range> ranges;
};

/// Lays out the efforts and constraints of a scene. Its solids must be laid out already.
class ActionSites {
 public:
  /// `solids`: their indices by name. All arguments must outlive this object.
  ActionSites(const Scene& scene, const std::map<std::string, int>& solids,
              const std::map<std::string, KnownCoordinate>& coordinates, System& system)
      : scene_(scene), solids_(solids), coordinates_(coordinates), system_(system) {}

  /// Adds all efforts, or all constraints, to the system. Errors name the effort or constraint: a missing or
  /// duplicate name, an unknown solid or coordinate, a number that is not finite, or a complaint of its kind.
  Result<void> add_efforts();
  Result<void> add_constraints();

  /// The largest distance of a named point from the origin of its solid, m.
  double farthest() const { return farthest_; }

 private:
  struct FieldVisitor;
  template <class Thing>
  Result<Action> resolve(const Thing& thing, const char* what, std::set<std::string>& names);
  Result<const KnownCoordinate*> coordinate(const std::string& name) const;
  CoordinateSite site_of(const KnownCoordinate& known) const;

  const Scene& scene_;
  const std::map<std::string, int>& solids_;
  const std::map<std::string, KnownCoordinate>& coordinates_;
  System& system_;
  double farthest_ = 0;
};

}  // namespace borelli
