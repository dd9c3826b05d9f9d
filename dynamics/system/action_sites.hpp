// What efforts and constraints act on: the solids and coordinates that their fields name, looked up once.
#pragma once

#include <map>
#include <set>
#include <string>

#include "dynamics/system/system.hpp"

namespace borelli {

/// What compile knows of a coordinate by its name.
struct KnownCoordinate {
  int step = -1;  ///< -1: locked
  int nq = 0;
  double value = 0;                         ///< of a locked scalar
  Quaternion turn = identity_quaternion();  ///< of a locked ball
  std::string solid;
  std::vector<Range> ranges;
};

/// Lays out the efforts and constraints of a scene whose solids are laid out.
class ActionSites {
 public:
  /// `solids`: their numbers by name. All three must outlive this.
  ActionSites(const Scene& scene, const std::map<std::string, int>& solids,
              const std::map<std::string, KnownCoordinate>& coordinates, System& system)
      : scene_(scene), solids_(solids), coordinates_(coordinates), system_(system) {}

  /// Each fails with the name of the effort or constraint: one that is used twice or not there, a solid or
  /// coordinate that is not there, a number that is not finite or that its kind complains of.
  Result<void> add_efforts();
  Result<void> add_constraints();

  /// The farthest point from its solid's origin that any of them names, m.
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
