// A user's own effort: any law of state and time, in C++.
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

/// What an OwnEffort does, over each scalar of the engine.
class OwnLaw {
 public:
  virtual ~OwnLaw() = default;
  virtual void apply(EffortPass<double>& pass) const = 0;
  virtual void apply(EffortPass<DualNumber>& pass) const = 0;
};

/// An effort by a class of the user's, which reads the motion of the solids and coordinates named here (by
/// their numbers in these lists) and leaves forces, torques, its potential and its power in the scan
/// (passes.hpp), like the kinds of the engine do. Written once over the scalar, it has exact derivatives:
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
/// What it does beside its potential belongs in pass.power(), W, or the certificate's energy balance is off
/// and the run distrusted. No momentum is taken as conserved where it acts. It may throw: the run then ends
/// with what it says. Called from several threads at once if the user runs several. Not written to scene
/// files.
struct OwnEffort {
  static constexpr std::string_view kind = "own";
  static constexpr bool is_code = true;
  std::vector<SolidName> solids;           ///< sites 0, 1, ... of the scan
  std::vector<AnyCoordinate> coordinates;  ///< coordinates 0, 1, ... of the scan
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
