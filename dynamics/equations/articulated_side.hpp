// The passes of articulated.hpp over alike trees, one SIMD lane per tree: articulated_step.hpp on numbers
// gathered from the lanes' bodies. inverse_dynamics.cpp shares part of it. Only articulated.cpp and
// inverse_dynamics.cpp include this file.
#pragma once

#include <variant>

#include "dynamics/equations/articulated_step.hpp"

namespace borelli::articulated {

using Each = AlikeTrees::Each;

/// Packs one number per lane, of its body, step or coordinate.
template <class F>
Quad gather(F&& of_lane) {
  return Quad(Quad::Vector{of_lane(0), of_lane(1), of_lane(2), of_lane(3)});
}

template <class F>
void gather(F&& of_lane, Vector3<Quad>& to) {
  const auto &a = of_lane(0), &b = of_lane(1), &c = of_lane(2), &d = of_lane(3);
  for (int i = 0; i < 3; ++i) to[i] = Quad(Quad::Vector{a[i], b[i], c[i], d[i]});
}

template <class F>
void gather(F&& of_lane, Matrix3<Quad>& to) {
  const auto &a = of_lane(0), &b = of_lane(1), &c = of_lane(2), &d = of_lane(3);
  for (int i = 0; i < 9; ++i)
    to.data()[i] = Quad(Quad::Vector{a.data()[i], b.data()[i], c.data()[i], d.data()[i]});
}

inline void lane_of(const Vector3<Quad>& from, int lane, Vector3<double>& to) {
  for (int i = 0; i < 3; ++i) to[i] = from[i][lane];
}
inline void lane_of(const Matrix3<Quad>& from, int lane, Matrix3<double>& to) {
  for (int i = 0; i < 9; ++i) to.data()[i] = from.data()[i][lane];
}

/// Writes one lane's articulated body at the tree's base to the link that carries the tree; `added`: adds it.
template <bool added>
void put_lane(const ArticulatedBody<Quad>& from, int lane, ArticulatedBody<double>& to) {
  const auto put_symmetric = [&](const Symmetric3<Quad>& a, Symmetric3<double>& b) {
    put<added>(a.xx[lane], b.xx), put<added>(a.xy[lane], b.xy), put<added>(a.xz[lane], b.xz);
    put<added>(a.yy[lane], b.yy), put<added>(a.yz[lane], b.yz), put<added>(a.zz[lane], b.zz);
  };
  const auto put_entries = [&](const auto& a, auto& b) {
    for (int i = 0; i < a.size(); ++i) put<added>(a.data()[i][lane], b.data()[i]);
  };
  put_symmetric(from.M, to.M);
  put_entries(from.bias.f, to.bias.f);
  const InertiaBound<double> bound{from.bound.mass[lane], from.bound.polar[lane], from.bound.reach[lane]};
  if constexpr (added)
    to.bound.add(bound);
  else
    to.bound = bound;
  to.extended = from.extended || (added && to.extended);
  if (from.extended) {
    put_symmetric(from.I, to.I);
    put_entries(from.H, to.H);
    put_entries(from.bias.n, to.bias.n);
  } else if constexpr (!added) {
    flatten(to);
  }
}

/// One kind of switch with each lane's parameters.
template <class Kind>
auto side_kind(const Parameters& parameters, const Each& steps) {
  if constexpr (requires { typename Kind::template Over<Quad>; }) {
    using Over = typename Kind::template Over<Quad>;
    const double* from[Quad::count][sizeof(Over) / sizeof(Quad)];  // (Over has no members but its fields)
    for (int lane = 0; lane < Quad::count; ++lane) {
      int n = 0;
      Kind::fields(*std::get_if<Kind>(&parameters.kinds[steps[lane]]),
                   [&]<class Field>(std::string_view, const Field& field) {
                     if constexpr (std::is_same_v<Field, double>)
                       from[lane][n++] = &field;
                     else
                       for (const double& x : field) from[lane][n++] = &x;
                   });
    }
    Over out;
    int n = 0;
    const auto next = [&] {
      const Quad x = gather([&](int lane) { return *from[lane][n]; });
      ++n;
      return x;
    };
    Kind::fields(out, [&]<class Field>(std::string_view, Field& field) {
      if constexpr (std::is_same_v<Field, Quad>)
        field = next();
      else
        for (Quad& x : field) x = next();
    });
    return out;
  } else {
    static_assert(std::is_empty_v<Kind> || Kind::nv == 0 || Bending<Kind>,  // (those are never side by side)
                  "a switch with numbers needs Over (switch_rotation.hpp)");
    return Kind();
  }
}

struct SidePlacement {
  Placement::Form form = Placement::Form::identity;
  PoseOf<Quad> X;
};

inline SidePlacement side_placement(const Parameters& parameters, const Each& steps) {
  SidePlacement out;
  for (int step : steps) out.form = std::max(out.form, parameters.placements[step].form);
  if (out.form == Placement::Form::identity) return out;
  const auto X = [&](int lane) -> const Pose& { return parameters.placements[steps[lane]].X; };
  gather(
      [&](int lane) -> auto& { return X(lane).p; }, out.X.p);
  if (out.form == Placement::Form::general)
    gather(
        [&](int lane) -> auto& { return X(lane).R; }, out.X.R);
  return out;
}

inline Quad side_armature(const Parameters& parameters, const Each& steps) {
  return gather([&](int lane) { return parameters.armatures[steps[lane]]; });
}

/// The link before a step; null: the world.
inline LinkOf<Quad>* before_in(SideBySide& side, const SideBySide::StepOf& step) {
  if (step.before >= 0) return &side.steps[step.before].link;
  return step.before == SideBySide::by_world ? nullptr : &side.carrier;
}

/// Link that carries a lane's tree. Not for trees on the world.
inline LinkOf<double>& carrying_link(const System& system, const SideBySide& side, int lane,
                                     Articulation& articulation) {
  return *articulation.link(system.bodies[side.trees.bodies[0][lane]].parent);
}

/// Updates the state of `swings`.
inline void swing(const Parameters& parameters, const Kinematics& k, SideBySide& side) {
  Swings& swings = *side.swings;
  side.swung = true;
  swings.update(parameters);
  const SideBySide::StepOf& step = side.steps[0];
  const Quad q = gather([&](int lane) { return k.q[step.q[lane]]; });
  swings.u = gather([&](int lane) { return k.u[step.u[lane]]; });
  swings.cos_q = cos(q);
  swings.sin_q = sin(q);
}

/// Repacks a body's inertial elements after a change.
[[gnu::noinline, gnu::cold]] inline void find_inertial(const InertialsOf<double>& inertials,
                                                       const Each& bodies, SideBySide::BodyOf& body) {
  for (int lane = 0; lane < Quad::count; ++lane) {
    body.inertials[lane] = inertials[bodies[lane]];
    body.inertial.set(lane, body.inertials[lane]);
  }
  body.inertial.settle();
}

/// `given`: whether the accelerations in k were given.
inline void move_links_of_side(const System& system, const Parameters& parameters,
                               const InertialsOf<double>& inertials, bool given, Articulation& articulation,
                               const Kinematics& k, SideBySide& side) {
  side.swung = false;
  if (side.steps[0].before == SideBySide::by_carrier) {
    LinkMotion<Quad>& to = side.carrier.motion;
    const auto of = [&](int lane) -> auto& { return carrying_link(system, side, lane, articulation).motion; };
    gather(
        [&](int lane) -> auto& { return of(lane).R; }, to.R);
    gather(
        [&](int lane) -> auto& { return of(lane).w; }, to.w);
    gather(
        [&](int lane) -> auto& { return of(lane).wdot; }, to.wdot);
    gather(
        [&](int lane) -> auto& { return of(lane).vdot; }, to.vdot);
  }
  for (std::size_t b = 0; b < side.trees.bodies.size(); ++b) {
    SideBySide::BodyOf& body = side.bodies[b];
    const int end = side.bodies[b + 1].first_step;
    for (int s = body.first_step; s < end; ++s) {
      SideBySide::StepOf& step = side.steps[s];
      step.link.carries = false;
      const LinkOf<Quad>* before = before_in(side, step);
      const SidePlacement placement = side_placement(parameters, step.steps);
      std::visit(
          [&]<class Kind>(const Kind&) {
            Quad q[Kind::nq + 1], u[Kind::nv + 1], acceleration[Kind::nv + 1];
            for (int i = 0; i < Kind::nq; ++i) q[i] = gather([&](int lane) { return k.q[step.q[lane] + i]; });
            for (int i = 0; i < Kind::nv; ++i) u[i] = gather([&](int lane) { return k.u[step.u[lane] + i]; });
            for (int i = 0; i < Kind::nv && given; ++i)
              acceleration[i] = gather([&](int lane) { return k.acceleration[step.u[lane] + i]; });
            step.stays = !Kind::slides && placement.form == Placement::Form::identity;
            step.loose =
                turns_freely<Kind> && !given && everywhere(side_armature(parameters, step.steps) == 0);
            step.link.motion = move<decltype(side_kind<Kind>(parameters, step.steps)), SidePlacement, Quad>(
                side_kind<Kind>(parameters, step.steps), placement, step.loose,
                before ? &before->motion : nullptr, q, u, given ? acceleration : nullptr,
                side.pivots.data() + step.first_pivot, step.link.turning);
          },
          parameters.kinds[step.steps[0]]);
    }
    const Each& each = side.trees.bodies[b];
    const LinkMotion<Quad>& motion = side.steps[end - 1].link.motion;
    if (system.bodies[each[0]].massive) {
      Changes changes;
      for (int lane = 0; lane < Quad::count; ++lane) changes.add(inertials[each[lane]], body.inertials[lane]);
      if (changes.any()) [[unlikely]]
        find_inertial(inertials, each, body);
      body.arm = motion.R * body.inertial.centre;
    } else {
      body.arm.setZero();
    }
  }
}

inline void move_side(const System& system, const Parameters& parameters,
                      const InertialsOf<double>& inertials, bool given, Articulation& articulation,
                      const Kinematics& k, SideBySide& side) {
  if (side.swings && !given)
    swing(parameters, k, side);
  else
    move_links_of_side(system, parameters, inertials, given, articulation, k, side);
}

inline void place_side(const System& system, const Parameters& parameters, Articulation& articulation,
                       const Kinematics& k, SideBySide& side) {
  if (side.swung) return;
  if (side.steps[0].before == SideBySide::by_carrier) {
    LinkPlace<Quad>& to = side.carrier.place;
    const auto of = [&](int lane) -> auto& { return carrying_link(system, side, lane, articulation).place; };
    gather(
        [&](int lane) -> auto& { return of(lane).p; }, to.p);
    gather(
        [&](int lane) -> auto& { return of(lane).v; }, to.v);
  }
  for (SideBySide::StepOf& step : side.steps)
    std::visit(
        [&]<class Kind>(const Kind&) {
          Quad u[Kind::nv + 1];
          for (int i = 0; i < Kind::nv && Kind::slides; ++i)
            u[i] = gather([&](int lane) { return k.u[step.u[lane] + i]; });
          find_place<Kind, Quad>(before_in(side, step), u, side.pivots.data() + step.first_pivot, step.link);
        },
        parameters.kinds[step.steps[0]]);
}

/// Moves the links of trees for which only the pendulum equation was used so far.
inline void unswing(const System& system, const Parameters& parameters, const InertialsOf<double>& inertials,
                    Articulation& articulation, const Kinematics& k, SideBySide& side) {
  if (!side.swung) return;
  move_links_of_side(system, parameters, inertials, false, articulation, k, side);
  place_side(system, parameters, articulation, k, side);
}

inline void find_bodies_of_side(const SideBySide& side, Kinematics& k) {
  for (std::size_t b = 0; b < side.trees.bodies.size(); ++b) {
    const SideBySide::BodyOf& body = side.bodies[b];
    const LinkOf<Quad>& link = side.steps[side.bodies[b + 1].first_step - 1].link;
    const LinkMotion<Quad>& motion = link.motion;
    const Vector3<Quad> g = link.place.p + body.arm, v = link.place.v + motion.w.cross(body.arm);
    for (int lane = 0; lane < Quad::count; ++lane) {
      BodyMotion& m = k.bodies[side.trees.bodies[b][lane]];
      lane_of(motion.R, lane, m.X.R);
      lane_of(link.place.p, lane, m.X.p);
      lane_of(motion.w, lane, m.w);
      lane_of(g, lane, m.g);
      lane_of(v, lane, m.v);
    }
  }
}

inline void find_energies_of_side(const System& system, const Parameters& parameters, const SideBySide& side,
                                  LagrangeTerms& terms) {
  Quad kinetic = 0, potential = 0;
  if (side.swung) {
    const Swings& swings = *side.swings;
    kinetic = 0.5 * swings.inertia * swings.u * swings.u;
    potential = swings.level + swings.cosine * swings.cos_q + swings.sine * swings.sin_q;
  } else {
    for (std::size_t b = 0; b < side.trees.bodies.size(); ++b) {
      if (!system.bodies[side.trees.bodies[b][0]].massive) continue;
      const auto [moving, lying] = energies<Quad>(side.bodies[b].inertial, parameters.gravity,
                                                  side.steps[side.bodies[b + 1].first_step - 1].link);
      kinetic += moving;
      potential += lying;
    }
  }
  for (int lane = 0; lane < side.trees.count; ++lane) {
    const int group = system.bodies[side.trees.bodies[0][lane]].group;  // group of the whole tree
    terms.kinetic += kinetic[lane];
    terms.potential += potential[lane];
    terms.group_kinetic[group] += kinetic[lane];
    terms.group_potential[group] += potential[lane];
  }
}

/// Inward pass: adds the trees' articulated bodies to the links that carry them. Returns false if a
/// coordinate meets negligible inertia.
inline bool free_side(const System& system, const Parameters& parameters, const EffortSums* efforts,
                      const double* given, Articulation& articulation, SideBySide& side) {
  if (side.swung) {
    const Swings& swings = *side.swings;
    Quad& rest = side.pivots[0].rest;
    rest = swings.cosine * swings.sin_q - swings.sine * swings.cos_q;
    if (given) rest += gather([&](int lane) { return given[side.steps[0].u[lane]]; });
    return swings.sound;
  }
  ArticulatedBody<Quad> carried;  // articulated body carried by the current step
  for (int b = int(side.trees.bodies.size()) - 1; b >= 0; --b) {
    const SideBySide::BodyOf& body = side.bodies[b];
    const Each& each = side.trees.bodies[b];
    const int last = side.bodies[b + 1].first_step - 1;
    const LinkOf<Quad>& link = side.steps[last].link;
    const bool touched = efforts && system.bodies[each[0]].touched;
    const auto find_applied = [&] {
      Vector3<Quad> force, moment;
      gather(
          [&](int lane) -> auto& { return efforts->force[each[lane]]; }, force);
      gather(
          [&](int lane) -> auto& { return efforts->moment[each[lane]]; }, moment);
      return Wrench<Quad>{moment + body.arm.cross(force), force};
    };
    const bool hangs = side.steps[last].loose && !link.carries && system.bodies[each[0]].massive &&
                       body.inertial.round;  // a pendant on its ball
    if (!hangs) {
      if (system.bodies[each[0]].massive) {
        put_own<false>(body.inertial, parameters.gravity, link.motion, !side.steps[last].loose, carried);
        if (link.carries) add(link.body, carried);
      } else if (link.carries) {
        carried = link.body;
      } else {
        carried = {};
      }
      if (touched) {
        const Wrench<Quad> applied = find_applied();
        carried.bias.n -= applied.n;
        carried.bias.f -= applied.f;
        carried.extended = true;
      }
    }
    for (int s = last; s >= body.first_step; --s) {
      SideBySide::StepOf& step = side.steps[s];
      LinkOf<Quad>* before = before_in(side, step);
      const bool followed = std::visit(
          [&]<class Kind>(const Kind&) {
            const auto along = [&](const double* from, Quad* to) {
              if (!from) return static_cast<Quad*>(nullptr);
              for (int i = 0; i < Kind::nv; ++i)
                to[i] = gather([&](int lane) { return from[step.u[lane] + i]; });
              return to;
            };
            Quad room[2][Kind::nv + 1];
            const Quad *const acting = along(efforts ? efforts->coordinate.data() : nullptr, room[0]),
                              *const added = along(given, room[1]);
            if constexpr (turns_freely<Kind>)
              if (hangs && s == last) {
                const auto hang = [&](const Wrench<Quad>* applied) {
                  let_hang<Quad>(body.inertial, parameters.gravity, applied, acting, added, !before, carried,
                                 step.link);
                };
                if (touched) {
                  const Wrench<Quad> applied = find_applied();
                  hang(&applied);
                } else {
                  hang(nullptr);
                }
                return true;
              }
            return free_step<Kind, Quad>(side_armature(parameters, step.steps), step.loose, acting, added,
                                         nullptr, !before, side.pivots.data() + step.first_pivot, carried,
                                         step.link);
          },
          parameters.kinds[step.steps[0]]);
      if (!followed) return false;
      if (before && !step.stays)
        move_origin<Quad>(step.link.motion.r, carried);
      else if (!carried.extended)
        flatten(carried);
      if (s > body.first_step || !before) continue;
      if (b == 0) {
        for (int lane = 0; lane < side.trees.count; ++lane) {
          LinkOf<double>& carrier = carrying_link(system, side, lane, articulation);
          if (carrier.carries)
            put_lane<true>(carried, lane, carrier.body);
          else
            put_lane<false>(carried, lane, carrier.body);
          carrier.carries = true;
        }
      } else {
        if (before->carries)
          add(carried, before->body);
        else
          before->body = carried;
        before->carries = true;
      }
    }
  }
  return true;
}

inline void follow_side(const System& system, const Parameters& parameters, Articulation& articulation,
                        SideBySide& side, double* a) {
  if (side.swung) {
    const Quad rate = side.swings->inverse * side.pivots[0].rest;
    for (int lane = 0; lane < Quad::count; ++lane) a[side.steps[0].u[lane]] = rate[lane];
    return;
  }
  if (side.steps[0].before == SideBySide::by_carrier) {
    const auto of = [&](int lane) -> auto& { return carrying_link(system, side, lane, articulation); };
    gather(
        [&](int lane) -> auto& { return of(lane).angular; }, side.carrier.angular);
    gather(
        [&](int lane) -> auto& { return of(lane).linear; }, side.carrier.linear);
  }
  for (std::size_t b = 0; b < side.trees.bodies.size(); ++b)
    for (int s = side.bodies[b].first_step; s < side.bodies[b + 1].first_step; ++s) {
      SideBySide::StepOf& step = side.steps[s];
      const LinkOf<Quad>* before = before_in(side, step);
      std::visit(
          [&]<class Kind>(const Kind&) {
            Quad rates[Kind::nv + 1];
            follow<Kind, Quad>(step.stays, step.loose, before, side.pivots.data() + step.first_pivot,
                               &side.bodies[b].inertial.pendant, step.link, rates, nullptr);
            for (int lane = 0; lane < Quad::count; ++lane)
              for (int i = 0; i < Kind::nv; ++i) a[step.u[lane] + i] = rates[i][lane];
          },
          parameters.kinds[step.steps[0]]);
    }
}

}  // namespace borelli::articulated
