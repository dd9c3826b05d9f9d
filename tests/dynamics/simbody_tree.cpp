#include "simbody_tree.hpp"

#include <Simbody.h>

namespace borelli::test {

namespace {

SimTK::Vec3 vec3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

SimTK::Transform transform(const SimbodyFrame& frame) {
  SimTK::Rotation R;
  R.setRotationToBodyFixedXYZ(vec3(frame.angles));
  return {R, vec3(frame.place)};
}

/// A function of one or no coordinate.
class AxisFunction : public SimTK::Function {
 public:
  explicit AxisFunction(const SimbodyAxis& axis) : axis_(axis) {}
  double calcValue(const SimTK::Vector& x) const override { return axis_.by(argument(x), 0); }
  double calcDerivative(const SimTK::Array_<int>& order, const SimTK::Vector& x) const override {
    return axis_.by(argument(x), int(order.size()));
  }
  int getArgumentSize() const override { return axis_.coordinate < 0 ? 0 : 1; }
  int getMaxDerivativeOrder() const override { return 2; }
  AxisFunction* clone() const override { return new AxisFunction(*this); }

 private:
  double argument(const SimTK::Vector& x) const { return axis_.coordinate < 0 ? 0 : x[0]; }
  SimbodyAxis axis_;
};

}  // namespace

struct SimbodyTree::Parts {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  std::map<std::string, SimTK::MobilizedBody> bodies;
  std::map<std::string, std::pair<std::string, int>> coordinates;  // by name: body, number
};

SimbodyTree::SimbodyTree() : parts_(std::make_unique<Parts>()) {}
SimbodyTree::SimbodyTree(SimbodyTree&&) noexcept = default;
SimbodyTree::~SimbodyTree() = default;

void SimbodyTree::add(const std::string& name, const std::string& parent, const std::string& joint,
                      const SimbodyFrame& in_parent, const SimbodyFrame& in_body, const SimbodyMass& mass,
                      const std::vector<std::string>& coordinates, const std::vector<SimbodyAxis>& axes,
                      bool reversed) {
  const double* I = mass.inertia;
  const SimTK::Inertia about_origin =
      SimTK::Inertia(I[0], I[1], I[2], I[3], I[4], I[5]).shiftFromMassCenter(vec3(mass.centre), mass.mass);
  const SimTK::Body::Rigid body(SimTK::MassProperties(mass.mass, vec3(mass.centre), about_origin));
  SimTK::MobilizedBody& base = parent.empty() ? parts_->matter.updGround()
                                              : static_cast<SimTK::MobilizedBody&>(parts_->bodies[parent]);
  const SimTK::Transform F = transform(in_parent), M = transform(in_body);
  const auto direction = reversed ? SimTK::MobilizedBody::Reverse : SimTK::MobilizedBody::Forward;
  SimTK::MobilizedBody& added = parts_->bodies[name];
  if (joint == "pin") added = SimTK::MobilizedBody::Pin(base, F, body, M, direction);
  if (joint == "slider") added = SimTK::MobilizedBody::Slider(base, F, body, M, direction);
  if (joint == "ball") added = SimTK::MobilizedBody::Ball(base, F, body, M, direction);
  if (joint == "universal") added = SimTK::MobilizedBody::Universal(base, F, body, M, direction);
  if (joint == "planar") added = SimTK::MobilizedBody::Planar(base, F, body, M, direction);
  if (joint == "gimbal") added = SimTK::MobilizedBody::Gimbal(base, F, body, M, direction);
  if (joint == "free") added = SimTK::MobilizedBody::Free(base, F, body, M, direction);
  if (joint == "weld") added = SimTK::MobilizedBody::Weld(base, F, body, M);
  if (joint == "custom") {
    SimTK::Array_<const SimTK::Function*> functions;
    SimTK::Array_<SimTK::Array_<int>> arguments;
    SimTK::Array_<SimTK::Vec3> directions;
    for (const SimbodyAxis& axis : axes) {
      functions.push_back(new AxisFunction(axis));
      arguments.push_back(axis.coordinate < 0 ? SimTK::Array_<int>()
                                              : SimTK::Array_<int>(1, axis.coordinate));
      directions.push_back(vec3(axis.axis));
    }
    added = SimTK::MobilizedBody::FunctionBased(base, F, body, M, int(coordinates.size()), functions,
                                                arguments, directions, direction);
  }
  for (std::size_t i = 0; i < coordinates.size(); ++i) parts_->coordinates[coordinates[i]] = {name, int(i)};
}

std::map<std::string, double> SimbodyTree::accelerations(const std::map<std::string, Motion>& given,
                                                         const Eigen::Vector3d& gravity) {
  SimTK::Force::UniformGravity weight(parts_->forces, parts_->matter, vec3(gravity));
  SimTK::State state = parts_->system.realizeTopology();
  parts_->matter.setUseEulerAngles(state, true);
  parts_->system.realizeModel(state);
  const auto at = [&](const auto& place) {
    return int(parts_->bodies.at(place.first).getFirstQIndex(state)) + place.second;
  };
  SimTK::Vector rates(state.getNQ(), 0.0);
  for (const auto& [name, place] : parts_->coordinates) {
    parts_->bodies.at(place.first).setOneQ(state, place.second, given.at(name).q);
    rates[at(place)] = given.at(name).rate;
  }
  parts_->system.realize(state, SimTK::Stage::Position);
  SimTK::Vector speeds(state.getNU());
  parts_->matter.multiplyByNInv(state, false, rates, speeds);
  state.updU() = speeds;
  parts_->system.realize(state, SimTK::Stage::Acceleration);
  std::map<std::string, double> out;
  for (const auto& [name, place] : parts_->coordinates) out[name] = state.getQDotDot()[at(place)];
  return out;
}

}  // namespace borelli::test
