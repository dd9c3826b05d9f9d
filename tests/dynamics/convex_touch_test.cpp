// Where convex shapes touch. Distances: against closed forms, bounds from points of both shapes, and MuJoCo.
// Rows: against central differences.
#include "dynamics/equations/convex_touch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "convex_bodies.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/contacts/pass_through.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/scene/convex_direction.hpp"

#ifdef BORELLI_MUJOCO
#include "mujoco_model.hpp"
#endif

namespace borelli::test::convex_contact_test {
namespace {

ClosedMesh points_on_ball(Random& random, int count) {
  ClosedMesh out;
  for (int i = 0; i < count; ++i)
    out.vertices.push_back(
        0.5 * Vector3d(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)).normalized());
  return out;
}

/// Number 0 to 5: box, sphere, cylinder, ellipsoid, capsule, hull of 12 points.
Form random_form(Random& random, int number) {
  const auto size = [&] { return random.number(0.15, 0.5); };
  switch (number) {
    case 0:
      return Box{2 * Vector3d(size(), size(), size())};
    case 1:
      return Sphere{size()};
    case 2:
      return Cylinder{size(), 2 * size()};
    case 3:
      return Ellipsoid{Vector3d(size(), size(), size())};
    case 4:
      return Capsule{size(), 2 * size()};
    default:
      return points_on_ball(random, 12);
  }
}

Pose random_pose(Random& random, double distance) {
  const Vector3d direction(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1));
  const Vector3d axis(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1));
  return {rotation_about(axis.normalized(), random.number(-3, 3)), distance * direction.normalized()};
}

struct Placed {
  Form form;
  std::shared_ptr<const Convex> convex;
  Pose X;
};

struct TestPair {
  Placed a, b;
  int count = 8;
  ConvexTouch touch() const { return touch_of(*a.convex, a.X, *b.convex, b.X, count); }
};

/// Two shapes; a is moved away from b until their gap is `gap`.
TestPair pair_at(Random& random, int first, int second, double gap) {
  const Form fa = random_form(random, first), fb = random_form(random, second);
  TestPair out{{fa, make_convex(at_origin(fa)), random_pose(random, 1)},
               {fb, make_convex(at_origin(fb)), random_pose(random, 0)},
               std::min(most_contacts(fa), most_contacts(fb))};
  const Vector3d direction = out.a.X.p;
  double low = 0, high = 4;
  for (int i = 0; i < 60; ++i) {
    out.a.X.p = 0.5 * (low + high) * direction;
    (out.touch().gap < gap ? low : high) = 0.5 * (low + high);
  }
  return out;
}

/// Distance of a point outside a shape by its equation; approximate away from the surface.
double outside(const Placed& one, const Vector3d& p_W) {
  const Vector3d p = one.X.inverse() * p_W;
  if (const auto* box = std::get_if<Box>(&one.form)) return (p.cwiseAbs() - box->size / 2).maxCoeff();
  if (const auto* sphere = std::get_if<Sphere>(&one.form)) return p.norm() - sphere->radius;
  if (const auto* cylinder = std::get_if<Cylinder>(&one.form))
    return std::max(std::hypot(p.x(), p.y()) - cylinder->radius, std::abs(p.z()) - cylinder->length / 2);
  if (const auto* ellipsoid = std::get_if<Ellipsoid>(&one.form))
    return (p.cwiseQuotient(ellipsoid->radii).norm() - 1) * ellipsoid->radii.minCoeff();
  if (const auto* capsule = std::get_if<Capsule>(&one.form)) {
    const double z = std::clamp(p.z(), -capsule->length / 2, capsule->length / 2);
    return (p - Vector3d(0, 0, z)).norm() - capsule->radius;
  }
  double most = -1;
  for (const ConvexFace& face : one.convex->faces)
    most = std::max(most, face.normal.dot(p - one.convex->vertices[std::size_t(face.corners[0])]));
  return most;
}

/// A random point of the shape's surface. (The origin may lie outside a hull of random points.)
Vector3d some_point(const Placed& one, Random& random) {
  const Vector3d d(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1));
  const Vector3d centre = one.convex->centre;
  double low = 0, high = 2;
  for (int i = 0; i < 50; ++i)
    (outside(one, one.X * Vector3d(centre + 0.5 * (low + high) * d)) < 0 ? low : high) = 0.5 * (low + high);
  return one.X * Vector3d(centre + low * d);
}

// A gap is bounded from both sides: the plane separates the shapes by at least the gap, and two points of the
// shapes are that close.
TEST(ConvexTouch, GapsAreProvenByPointsOfBothShapes) {
  Random random(1);
  for (int first = 0; first < 6; ++first)
    for (int second = 0; second <= first; ++second)
      for (int trial = 0; trial < 6; ++trial) {
        const double wanted = trial % 3 == 0 ? 1e-9 : random.number(0, 0.1);
        const TestPair pair = pair_at(random, first, second, wanted);
        const ConvexTouch touch = pair.touch();
        const std::string which = fmt::format("{} on {}, trial {}", first, second, trial);
        // a normal counts as best within 1e-9 of the pair's size (convex_touch.hpp); the gap may leap by that
        ASSERT_NEAR(touch.gap, wanted, 1e-9 * (pair.a.convex->bound + pair.b.convex->bound)) << which;
        EXPECT_NEAR(touch.normal.norm(), 1, 1e-12);
        double low = 1e9, high = -1e9;
        for (int i = 0; i < 60; ++i) {
          low = std::min(low, touch.normal.dot(some_point(pair.a, random)));
          high = std::max(high, touch.normal.dot(some_point(pair.b, random)));
        }
        EXPECT_GE(low - high, touch.gap - 1e-9) << which;
        double nearest = 1e9;
        const bool on_b = touch.flat == ConvexTouch::Flat::a;
        for (const ConvexPoint& point : touch.points) {
          if (!point.used || point.gap > touch.gap + 1e-8) continue;
          const Vector3d other = point.p + (on_b ? 1 : -1) * point.gap * touch.normal;
          nearest = std::min(nearest, std::max(outside(on_b ? pair.b : pair.a, point.p),
                                               outside(on_b ? pair.a : pair.b, other)));
        }
        // clipping uses a polygon of 24 corners within the cylinder's rim
        EXPECT_LE(nearest, 1e-8) << which;
      }
}

TEST(ConvexTouch, EqualsClosedFormsOfSpheresBoxesAndCapsules) {
  Random random(2);
  for (int trial = 0; trial < 40; ++trial) {
    // a sphere and a box: the nearest point of the box by clamping
    const TestPair pair = pair_at(random, 1, 0, random.number(0, 0.1));
    const Vector3d half = std::get<Box>(pair.b.form).size / 2, c = pair.b.X.inverse() * pair.a.X.p;
    const Vector3d d = c - c.cwiseMax(-half).cwiseMin(half);
    const ConvexTouch touch = pair.touch();
    EXPECT_NEAR(touch.gap, d.norm() - std::get<Sphere>(pair.a.form).radius, 1e-12);
    EXPECT_LT((touch.normal - pair.b.X.R * d.normalized()).norm(), 1e-9);
    // two capsules
    const TestPair rods = pair_at(random, 4, 4, random.number(0, 0.1));
    const auto end = [](const Placed& one, double side) {
      return Vector3d(one.X * Vector3d(0, 0, side * std::get<Capsule>(one.form).length / 2));
    };
    EXPECT_NEAR(rods.touch().gap,
                segment_distance(end(rods.a, -1), end(rods.a, 1), end(rods.b, -1), end(rods.b, 1)) -
                    std::get<Capsule>(rods.a.form).radius - std::get<Capsule>(rods.b.form).radius,
                1e-12);
    // a box over a plane: its lowest corner
    const Vector3d on(0.1, 0.2, 0.3), n = random_pose(random, 1).p;
    double lowest = 1e9;
    for (int k = 0; k < 8; ++k) {
      const Vector3d corner(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      lowest = std::min(lowest, n.dot(pair.b.X * Vector3d(half.cwiseProduct(corner)) - on));
    }
    EXPECT_NEAR(touch_of_plane(*pair.b.convex, pair.b.X, on, n, n.unitOrthogonal(), 8).gap, lowest, 1e-13);
  }
}

TEST(ConvexTouch, BoxesFaceToFaceTouchAtTheCornersOfTheSharedArea) {
  const Form plank = Box{{2, 0.2, 0.1}}, beam = Box{{0.3, 1, 0.2}};
  const auto a = make_convex(at_origin(plank)), b = make_convex(at_origin(beam));
  const ConvexTouch touch =
      touch_of(*a, {Matrix3d::Identity(), {0.1, 0, 0.15 + 1e-6}}, *b, {Matrix3d::Identity(), {0, 0, 0}}, 8);
  EXPECT_LT((touch.normal - Vector3d::UnitZ()).norm(), 1e-12);
  int corners = 0;
  for (const ConvexPoint& point : touch.points) {
    if (!point.used) continue;
    ++corners;
    EXPECT_NEAR(point.gap, 1e-6, 1e-12);
    EXPECT_NEAR(std::abs(point.p.x()), 0.15, 1e-12);
    EXPECT_NEAR(std::abs(point.p.y()), 0.1, 1e-12);
  }
  EXPECT_EQ(corners, 4);
}

// In metres, assertions of FCL end the program for shapes of kilometres. Shapes of one size always have a
// direction; of two sizes, one may be flat beside the other and have none.
TEST(ConvexTouch, ShapesOfAllSizesHaveADirectionOrNone) {
  Random random(11);
  for (int trial = 0; trial < 30000; ++trial) {
    const bool alike = trial % 2 == 0;
    double scale = std::pow(10, random.number(-4, 11)), reach = 0;
    std::shared_ptr<const Convex> shapes[2];
    for (auto& shape : shapes) {
      if (!alike) scale = std::pow(10, random.number(-4, 11));
      const auto size = [&] { return scale * random.number(0.5, 2); };
      const Form forms[]{Box{Vector3d(size(), size(), size())}, Cylinder{size(), size()},
                         Cylinder{size(), alike ? size() : 1}, Ellipsoid{Vector3d(size(), size(), size())}};
      shape = make_convex(at_origin(forms[random.integer(0, 3)]));
      reach += scale;
    }
    const Pose X_a = random_pose(random, random.number(0, 2) * reach), X_b = random_pose(random, 1);
    const auto n = direction_between(*shapes[0], X_a, *shapes[1], X_b);
    ASSERT_TRUE(n || !alike) << scale;
    EXPECT_NEAR(n.value_or(Vector3d::UnitX()).norm(), 1, 1e-12);
  }
}

#ifdef BORELLI_MUJOCO

/// MuJoCo's least distance of the two geoms; empty if it finds no contact.
std::optional<double> of_mujoco(const TestPair& pair) {
  const auto geom = [](const Placed& one) {
    const Quaternion q = quaternion(one.X.R);
    std::string form;
    if (const auto* box = std::get_if<Box>(&one.form))
      form = fmt::format("'box' size='{:.17g}'", fmt::join(Vector3d(box->size / 2), " "));
    if (const auto* sphere = std::get_if<Sphere>(&one.form))
      form = fmt::format("'sphere' size='{:.17g}'", sphere->radius);
    if (const auto* c = std::get_if<Cylinder>(&one.form))
      form = fmt::format("'cylinder' size='{:.17g} {:.17g}'", c->radius, c->length / 2);
    if (const auto* c = std::get_if<Capsule>(&one.form))
      form = fmt::format("'capsule' size='{:.17g} {:.17g}'", c->radius, c->length / 2);
    if (const auto* e = std::get_if<Ellipsoid>(&one.form))
      form = fmt::format("'ellipsoid' size='{:.17g}'", fmt::join(e->radii, " "));
    return fmt::format("<body pos='{:.17g}' quat='{:.17g}'><freejoint/><geom type={}/></body>",
                       fmt::join(one.X.p, " "), fmt::join(q, " "), form);
  };
  Mujoco mujoco = Mujoco::of("<mujoco><worldbody>" + geom(pair.a) + geom(pair.b) + "</worldbody></mujoco>");
  mujoco.model->opt.disableflags &= ~(mjDSBL_CONSTRAINT | mjDSBL_CONTACT);
  mj_fwdPosition(mujoco.model, mujoco.data);
  if (mujoco.data->ncon == 0) return std::nullopt;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < mujoco.data->ncon; ++i) least = std::min(least, double(mujoco.data->contact[i].dist));
  return least;
}

/// Least depth of two boxes that overlap, m, by the separating axis theorem (Gottschalk, Lin and Manocha,
/// OBBTree, SIGGRAPH 1996): over the normals of their faces and the normals across an edge of each.
double depth_of_boxes(const TestPair& pair) {
  const auto reach = [](const Placed& one, const Vector3d& n) {
    const Vector3d along = one.X.R.transpose() * n;
    return along.cwiseAbs().dot(std::get<Box>(one.form).size) / 2;
  };
  double least = std::numeric_limits<double>::infinity();
  const auto try_normal = [&](const Vector3d& n) {
    const double between = std::abs(n.dot(pair.a.X.p - pair.b.X.p));
    least = std::min(least, reach(pair.a, n) + reach(pair.b, n) - between);
  };
  for (int i = 0; i < 3; ++i) {
    try_normal(pair.a.X.R.col(i));
    try_normal(pair.b.X.R.col(i));
    for (int j = 0; j < 3; ++j) try_normal(pair.a.X.R.col(i).cross(pair.b.X.R.col(j)).normalized());
  }
  return least;
}

TEST(ConvexTouch, OverlapsWhereMujocoSeesContacts) {
  Random random(4);
  for (int first = 0; first < 5; ++first)
    for (int second = 0; second <= first; ++second)
      for (int trial = 0; trial < 10; ++trial) {
        const double gap = (trial % 2 ? 1 : -1) * random.number(1e-4, 0.02);
        const TestPair pair = pair_at(random, first, second, gap);
        const auto found = of_mujoco(pair);
        const std::string which = fmt::format("{} on {}, trial {}, gap {}", first, second, trial, gap);
        ASSERT_EQ(found.has_value(), gap < 0) << which;
        if (!found) continue;
        if (first == 1) {
          EXPECT_NEAR(*found, gap, 1e-9) << which;  // MuJoCo has closed forms for these
        }
        if (first == 0) {
          EXPECT_NEAR(depth_of_boxes(pair), -gap, 1e-12) << which;
        }
      }
}

#endif

class ConvexRows : public testing::TestWithParam<std::tuple<int, int>> {};

// (Without cylinders over boxes: where the rim cuts the corner, its rows count it as fixed in its shape.)
// Central differences of the gap and its rate, for the nearest point. (A corner that both shapes cut, over
// faces that are not parallel, is farther; its rows count it as fixed in its shape.)
TEST_P(ConvexRows, AreTheDerivativesOfTheGap) {
  const auto [first, second] = GetParam();
  Random random(unsigned(10 * first + second + 3));
  int compared = 0;
  for (int trial = 0; trial < 6; ++trial) {
    TestPair pair = pair_at(random, first, second, 0.02);
    Scene scene;
    scene.solids = {body_of("a", 1, Sphere{1}, pair.a.X), body_of("b", 1, Sphere{1}, pair.b.X)};
    scene.constraints = {meets("a", pair.a.form, "b", pair.b.form, 0.5)};
    const System system = compiled(scene);
    State state = system.initial;
    for (double& v : state.v) v = random.number(-1, 1);
    const auto rows_at = [&](const Eigen::VectorXd& x) {
      Eigen::VectorXd q = state.q;
      from_local_coordinates(system, state.q.data(), x.data(), q.data());
      Kinematics kinematics(system);
      update_kinematics(system, system.parameters, 0, q.data(), state.v.data(), kinematics);
      ConstraintRows rows(system);
      rows.every_row = true;
      scan_constraints(system, system.parameters, kinematics, rows);
      return rows;
    };
    // differences err by h^2 times third derivatives (about 100 for the smallest roundness) and rounding / h
    const double h = 1e-5, tolerance = 1e-6;
    const ConstraintRows now = rows_at(0 * state.v), behind = rows_at(-h * state.v),
                         ahead = rows_at(h * state.v);
    double least = std::numeric_limits<double>::infinity();
    for (const Contact& c : system.contacts) least = std::min(least, now.h[c.row]);
    for (const Contact& c : system.contacts) {
      const double bend = ahead.h[c.row] + behind.h[c.row] - 2 * now.h[c.row];
      if (now.h[c.row] > least + 1e-9 || std::abs(bend) > 1e-7) continue;
      EXPECT_NEAR(now.rate[c.row], (ahead.h[c.row] - behind.h[c.row]) / (2 * h), tolerance) << trial;
      EXPECT_NEAR(now.E[c.row], (ahead.rate[c.row] - behind.rate[c.row]) / (2 * h), 20 * tolerance) << trial;
      for (int i = 0; i < system.nv; ++i) {
        const Eigen::VectorXd x = h * Eigen::VectorXd::Unit(system.nv, i);
        EXPECT_NEAR(now.L(c.row, i), (rows_at(x).h[c.row] - rows_at(-x).h[c.row]) / (2 * h), tolerance)
            << trial;
      }
      ++compared;
    }
  }
  EXPECT_GE(compared, 4);
}

INSTANTIATE_TEST_SUITE_P(Pairs, ConvexRows,
                         testing::Values(std::tuple(0, 0), std::tuple(1, 0), std::tuple(3, 0),
                                         std::tuple(3, 1), std::tuple(3, 3), std::tuple(4, 0),
                                         std::tuple(2, 3), std::tuple(2, 4), std::tuple(5, 3)));

}  // namespace
}  // namespace borelli::test::convex_contact_test
