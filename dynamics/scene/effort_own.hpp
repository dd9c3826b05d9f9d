// A user-defined effort: any law of state and time, in C++.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dynamics/numbers/dual.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class EffortPass;

/// The law of an OwnEffort, for each scalar type of the engine.
class OwnLaw {
 public:
  virtual ~OwnLaw() = default;
  virtual void apply(EffortPass<double>& pass) const = 0;
  virtual void apply(EffortPass<DualNumber>& pass) const = 0;
};

/// An effort by a user-defined class. It reads the motion of the solids and coordinates named here, by their
/// indices in these lists. Like the built-in kinds, it adds forces, torques, potential and power to the pass
/// (passes.hpp). Written once over the scalar type, it has exact derivatives:
///
///   struct Attraction {  // of a to b, strength / distance^2
///     double strength;
///     template <class T>
///     void apply(EffortPass<T>& pass) const {
///       using std::sqrt;
///       const auto a = pass.point(0, {0, 0, 0}), b = pass.point(1, {0, 0, 0});
///       const Eigen::Vector3<T> r = b.p - a.p;
///       const T d = sqrt(r.squaredNorm());
///       pass.force(0, a.p, strength / (d * d * d) * r);
///       pass.force(1, b.p, -strength / (d * d * d) * r);
///       pass.potential(-strength / d);
///     }
///   };
///   scene.efforts.push_back({"pull", OwnEffort({{"a"}, {"b"}}, {}, Attraction{3})});
///
/// Power beyond the change of its potential must go into pass.power(), W. Otherwise the energy balance of the
/// certificate fails and the run is not trusted. No momentum counts as conserved where it acts. It may throw:
/// the run then ends with that message. It is called from several threads at once if the user runs several.
/// It cannot be written to scene files.
struct OwnEffort {
  static constexpr std::string_view kind = "own";
  static constexpr bool is_code = true;
  std::vector<SolidName> solids;           ///< sites 0, 1, ... of the pass
  std::vector<AnyCoordinate> coordinates;  ///< coordinates 0, 1, ... of the pass
  std::shared_ptr<const OwnLaw> law;

  OwnEffort() = default;
  template <class Law>
  OwnEffort(std::vector<SolidName> on_solids, std::vector<AnyCoordinate> on_coordinates, Law own)
      : solids(std::move(on_solids)), coordinates(std::move(on_coordinates)) {
    struct Wrapped : OwnLaw {
      explicit Wrapped(Law given) : inner(std::move(given)) {}
      void apply(EffortPass<double>& pass) const override { inner.apply(pass); }
      void apply(EffortPass<DualNumber>& pass) const override { inner.apply(pass); }
      Law inner;
    };
    law = std::make_shared<Wrapped>(std::move(own));
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("solids", self.solids);
    visit("coordinates", self.coordinates);
  }

  std::string complaint() const { return law ? "" : "has no law; set one in C++"; }

  template <class T>
  void apply(EffortPass<T>& pass) const {
    if constexpr (requires { law->apply(pass); }) law->apply(pass);  // (batches refuse it: batch.hpp)
  }
};

}  // namespace borelli
