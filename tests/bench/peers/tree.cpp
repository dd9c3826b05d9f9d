#include "tree.hpp"

#include <Eigen/Eigenvalues>
#include <limits>
#include <map>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/scene/scene.hpp"
#include "dynamics/system/system.hpp"

namespace borelli::peers {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

class TreeMaker {
 public:
  TreeMaker(const Scene& scene, const System& system, const State& start, const Eigen::VectorXd& acceleration)
      : scene_(scene), system_(system), start_(start), acceleration_(acceleration) {
    tree_.gravity = scene.gravity;
    tree_.seats.resize(scene.solids.size());
    for (std::size_t s = 0; s < scene.solids.size(); ++s) number_[scene.solids[s].name] = s;
    done_.resize(scene.solids.size());
  }

  Result<Tree> make() {
    for (std::size_t s = 0; s < scene_.solids.size(); ++s)
      if (auto fine = place(s); !fine) return tl::unexpected(fine.error());
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      if (!(inertials_[i].mass > 0))
        return failure(tree_.links[i].name, "a link without mass: the other programs want one");
      set_inertia(tree_.links[i], inertials_[i]);
    }
    for (const Effort& e : scene_.efforts)
      if (auto fine = std::visit([&](const auto& kind) { return add(e.name, kind); }, e.kind); !fine)
        return tl::unexpected(fine.error());
    for (const Constraint& c : scene_.constraints)
      if (auto fine = std::visit([&](const auto& kind) { return add(c.name, kind); }, c.kind); !fine)
        return tl::unexpected(fine.error());
    return std::move(tree_);
  }

 private:
  static void set_inertia(Link& link, const Inertial& inertial) {
    link.mass = inertial.mass;
    link.centre = inertial.centre;
    if (inertial.tensor.isDiagonal(0)) {  // avoids rounding where it can
      link.moments = inertial.tensor.diagonal();
      return;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertial.tensor);
    link.moments = solver.eigenvalues().cwiseMax(0);
    link.principal = solver.eigenvectors();
    if (link.principal.determinant() < 0) link.principal.col(0) *= -1;
  }

  /// Assigns a solid its seat, after its parent's.
  Result<void> place(std::size_t s) {
    if (done_[s]) return {};
    const Solid& solid = scene_.solids[s];
    Tree::Seat seat;
    if (solid.parent != world_name) {
      const std::size_t parent = number_.at(solid.parent);
      if (auto fine = place(parent); !fine) return fine;
      seat = tree_.seats[parent];
    }
    bool jointed = false;
    for (std::size_t i = 0; i < solid.switches.size(); ++i) {
      const Switch& one = solid.switches[i];
      if (const auto* fixed = std::get_if<Fixed>(&one.kind)) {
        seat.p += seat.R * fixed->X_AB.p;
        seat.R *= fixed->X_AB.R;
        continue;
      }
      if (!std::holds_alternative<Free>(one.motion) || one.armature != 0)
        return failure(scene_.where(solid), "a joint that is driven, coupled, locked or has an armature");
      if (jointed) return failure(scene_.where(solid), "a joint of several switches");
      jointed = true;
      Link link;
      link.name = solid.name;
      link.parent = seat.link;
      link.R = seat.R;
      link.p = seat.p;
      if (is_free(solid, i)) {
        link.joint = Link::Joint::free;
        for (std::size_t k = i; k < i + 4; ++k) take_start(link, coordinate_name(solid, k));
        i += 3;
      } else {
        if (const auto* hinge = std::get_if<Rotation>(&one.kind)) {
          link.axis = hinge->axis.normalized();
        } else if (const auto* slide = std::get_if<Translation>(&one.kind)) {
          link.joint = Link::Joint::slide;
          link.axis = slide->axis.normalized();
        } else if (std::holds_alternative<Ball>(one.kind)) {
          link.joint = Link::Joint::ball;
        } else {
          return failure(scene_.where(solid), "a screw");
        }
        take_start(link, coordinate_name(solid, i));
      }
      seat = {int(tree_.links.size()), Matrix3d::Identity(), Vector3d::Zero()};
      tree_.links.push_back(link);
      inertials_.emplace_back();
    }
    const auto parts = inertials_of(solid);
    if (!parts) return tl::unexpected(parts.error());
    if (seat.link >= 0)
      for (const Inertial& part : *parts) inertials_[seat.link] += part.expressed_in(seat.R, seat.p);
    tree_.seats[s] = seat;
    done_[s] = true;
    return {};
  }

  /// Three slides along x, y, z and a ball.
  static bool is_free(const Solid& solid, std::size_t i) {
    if (i + 4 > solid.switches.size()) return false;
    for (int k = 0; k < 3; ++k) {
      const auto* slide = std::get_if<Translation>(&solid.switches[i + k].kind);
      if (!slide || slide->axis != Vector3d::Unit(k)) return false;
    }
    for (std::size_t k = i; k < i + 4; ++k)
      if (!std::holds_alternative<Free>(solid.switches[k].motion) || solid.switches[k].armature != 0)
        return false;
    return std::holds_alternative<Ball>(solid.switches[i + 3].kind);
  }

  void take_start(Link& link, const std::string& coordinate) {
    for (const CoordinateInfo& c : system_.coordinates) {
      if (c.name != coordinate) continue;
      for (int i = 0; i < c.q_size; ++i) link.q.push_back(start_.q[c.q_index + i]);
      for (int i = 0; i < c.v_size; ++i) {
        link.v.push_back(start_.v[c.v_index + i]);
        link.a.push_back(acceleration_[c.v_index + i]);
      }
    }
  }

  At at(const SolidPoint& p) const {
    if (p.solid == world_name) return {-1, p.point};
    const Tree::Seat& seat = tree_.seats[number_.at(p.solid)];
    return {seat.link, seat.R * p.point + seat.p};
  }
  Vector3d along(const std::string& solid, const Vector3d& direction) const {
    return solid == world_name ? direction : Vector3d(tree_.seats[number_.at(solid)].R * direction);
  }

  Result<void> add(const std::string&, const PointSpring& s) {
    tree_.springs.push_back({at(s.a), at(s.b), s.stiffness, s.damping, s.rest_length});
    return {};
  }
  Result<void> add(const std::string& name, const CoordinateSpring& s) {
    for (std::size_t k = 0; k < scene_.solids.size(); ++k) {
      const Solid& solid = scene_.solids[k];
      for (std::size_t i = 0; i < solid.switches.size(); ++i) {
        if (coordinate_name(solid, i) != s.on.coordinate) continue;
        const int link = tree_.seats[k].link;
        if (tree_.links[link].v.size() != 1) return failure(name, "a spring on a joint of several switches");
        tree_.joint_springs.push_back({link, s.stiffness, s.damping, s.rest});
        return {};
      }
    }
    return failure(name, "a spring on no joint");
  }
  Result<void> add(const std::string& name, const Torque& t) {
    if (t.axes != Axes::world || t.reaction || !is(t.factor, 1))
      return failure(name, "a torque that is not constant, or has a reaction");
    tree_.turns.push_back({tree_.seats[number_.at(t.on.solid)].link, t.torque});
    return {};
  }
  Result<void> add(const std::string&, const PointOnPoint& c) {
    tree_.held.push_back({at(c.a), at(c.b)});
    return {};
  }
  Result<void> add(const std::string& name, const PointOnPlane& c) {
    if (!is(c.offset, 0)) return failure(name, "a plane that moves in its solid");
    tree_.in_planes.push_back({at(c.point), at(c.plane.on), along(c.plane.on.solid, c.plane.normal)});
    return {};
  }
  Result<void> add(const std::string& name, const SphereOverPlane& c) {
    return add_ground(name, at(c.sphere), c.radius, Vector3d::Zero(), c.plane, c.surface);
  }
  Result<void> add(const std::string& name, const BoxOverPlane& c) {
    if (!tree_.seats[number_.at(c.box.solid)].R.isIdentity(0))
      return failure(name, "a box askew in its link");
    return add_ground(name, at(c.box), 0, c.size, c.plane, c.surface);
  }
  Result<void> add_ground(const std::string& name, const At& centre, double radius, const Vector3d& size,
                          const Plane& plane, const ContactSurface& surface) {
    const At on = at(plane.on);
    if (on.link >= 0 || centre.link < 0) return failure(name, "a ground that is not the world's");
    tree_.grounds.push_back({centre, radius, size, on.point, along(plane.on.solid, plane.normal).normalized(),
                             surface.restitution, surface.friction});
    return {};
  }
  template <class Kind>
  Result<void> add(const std::string& name, const Kind&) {
    return failure(name, "'" + std::string(Kind::kind) + "' has no twin in the other programs here");
  }

  static bool is(const TimeFunction& f, double value) {
    const auto* p = std::get_if<Polynomial>(&f);
    return p && borelli::at(f, 0).value == value && borelli::at(f, 1).value == value;
  }

  const Scene& scene_;
  const System& system_;
  const State& start_;
  const Eigen::VectorXd& acceleration_;
  Tree tree_;
  std::vector<Inertial> inertials_;  ///< per link
  std::map<std::string, std::size_t> number_;
  std::vector<char> done_;
};

Vector3d place_of(const Moving* links, const At& at) {
  return at.link < 0 ? at.point : Vector3d(links[at.link].R * at.point + links[at.link].p);
}

}  // namespace

Result<Tree> tree_of(const Scene& scene, const System& system) {
  State start = system.initial;
  if (auto fine = assemble(system, start); !fine) return tl::unexpected(fine.error());
  const auto equations = evaluate(system, start);
  if (!equations) return tl::unexpected(equations.error());
  return TreeMaker(scene, system, start, equations->acceleration).make();
}

Result<Tree> with_held_points(const Tree& tree) {
  Tree out = tree;
  out.in_planes.clear();
  const auto lacking = [] { return failure("", "has no twin of a point on a plane of another solid"); };
  if (tree.in_planes.size() % 2 != 0) return lacking();
  const Start start = start_of(tree);
  const auto turned = [&](int link, const Vector3d& v) {
    return link < 0 ? v : Vector3d(start.links[link].R * v);
  };
  for (std::size_t i = 0; i < tree.in_planes.size(); i += 2) {
    const InPlane &a = tree.in_planes[i], &b = tree.in_planes[i + 1];
    const Vector3d across = turned(a.plane.link, a.normal).cross(turned(b.plane.link, b.normal));
    bool planar = a.point.link == b.point.link && a.point.point == b.point.point &&
                  a.plane.link == b.plane.link && a.plane.point == b.plane.point && across.norm() > 0.99;
    for (std::size_t k = 0; k < tree.links.size(); ++k) {
      const Link& link = tree.links[k];
      planar = planar && link.joint == Link::Joint::hinge &&
               turned(int(k), link.axis).cross(across).norm() < 1e-12;
    }
    if (!planar) return lacking();
    out.held.push_back({a.point, a.plane});
  }
  return out;
}

Start start_of(const Tree& tree) {
  Start out;
  std::vector<Vector3d> v, a;  // of the links' origins
  for (const Link& link : tree.links) {
    // the joint's frame, as fixed on the parent
    Moving m{link.R, link.p, Vector3d::Zero(), Vector3d::Zero()};
    Vector3d speed = Vector3d::Zero(), rate = speed, alpha = speed, base = speed;
    if (link.parent >= 0) {
      const Moving& parent = out.links[link.parent];
      base = parent.p;
      m = {parent.R * link.R, parent.R * link.p + parent.p, parent.omega, Vector3d::Zero()};
      speed = v[link.parent], rate = a[link.parent], alpha = out.alpha[link.parent];
    }
    const Vector3d omega = m.omega;  // of the parent
    const auto three = [](const std::vector<double>& x, std::size_t i) {
      return Vector3d(x[i], x[i + 1], x[i + 2]);
    };
    // translation
    Vector3d shift = Vector3d::Zero(), slide = shift, push = shift;
    if (link.joint == Link::Joint::slide)
      shift = m.R * link.axis * link.q[0], slide = m.R * link.axis * link.v[0],
      push = m.R * link.axis * link.a[0];
    else if (link.joint == Link::Joint::free)
      shift = m.R * three(link.q, 0), slide = m.R * three(link.v, 0), push = m.R * three(link.a, 0);
    m.p += shift;
    const Vector3d arm = m.p - base;
    speed += omega.cross(arm) + slide;
    rate += alpha.cross(arm) + omega.cross(omega.cross(arm)) + 2 * omega.cross(slide) + push;
    // rotation
    Vector3d turn = Vector3d::Zero(), turn_rate = turn;
    if (link.joint == Link::Joint::hinge) {
      turn = m.R * link.axis * link.v[0], turn_rate = m.R * link.axis * link.a[0];
      m.R *= rotation_about(link.axis, link.q[0]);
    } else if (link.joint != Link::Joint::slide) {
      const std::size_t i = link.joint == Link::Joint::free ? 3 : 0;
      m.R *= rotation_matrix(Quaternion(link.q[i], link.q[i + 1], link.q[i + 2], link.q[i + 3]));
      turn = m.R * three(link.v, i), turn_rate = m.R * three(link.a, i);
    }
    alpha += omega.cross(turn) + turn_rate;
    m.omega = omega + turn;
    const Vector3d centre = m.R * link.centre;
    m.centre = speed + m.omega.cross(centre);
    out.acceleration.push_back(rate + alpha.cross(centre) + m.omega.cross(m.omega.cross(centre)));
    out.alpha.push_back(alpha);
    out.links.push_back(m);
    v.push_back(speed), a.push_back(rate);
  }
  return out;
}

Vector3d momentum(const Tree& tree, const Moving* links) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < tree.links.size(); ++i) sum += tree.links[i].mass * links[i].centre;
  return sum;
}

double energy(const Tree& tree, const Moving* links) {
  if (!tree.joint_springs.empty() || !tree.turns.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    const Link& link = tree.links[i];
    const Moving& m = links[i];
    const Vector3d own = (m.R * link.principal).transpose() * m.omega;
    sum += 0.5 * link.mass * m.centre.squaredNorm() + 0.5 * own.dot(link.moments.cwiseProduct(own));
    sum -= link.mass * tree.gravity.dot(m.R * link.centre + m.p);
  }
  for (const Spring& s : tree.springs) {
    const double stretch = (place_of(links, s.a) - place_of(links, s.b)).norm() - s.rest;
    sum += 0.5 * s.stiffness * stretch * stretch;
  }
  return sum;
}

double residual(const Tree& tree, const Moving* links) {
  double worst = 0;
  for (const Held& h : tree.held)
    worst = std::max(worst, (place_of(links, h.a) - place_of(links, h.b)).norm());
  for (const InPlane& c : tree.in_planes) {
    const Vector3d n = c.plane.link < 0 ? c.normal : Vector3d(links[c.plane.link].R * c.normal);
    worst = std::max(worst, std::abs(n.dot(place_of(links, c.point) - place_of(links, c.plane))));
  }
  return worst;
}

std::vector<Vector3d> touching_points(const Ground& ground, const Moving& link) {
  const Vector3d centre = link.R * ground.centre.point + link.p;
  if (ground.radius > 0 || ground.size.isZero()) return {centre - ground.radius * ground.normal};
  std::vector<Vector3d> out;
  for (int k = 0; k < 8; ++k) {
    const Vector3d side(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
    out.push_back(centre + link.R * side.cwiseProduct(ground.size));
  }
  return out;
}

double penetration(const Tree& tree, const Moving* links) {
  double deepest = 0;
  for (const Ground& g : tree.grounds)
    for (const Vector3d& p : touching_points(g, links[g.centre.link]))
      deepest = std::max(deepest, -g.normal.dot(p - g.on));
  return deepest;
}

}  // namespace borelli::peers
