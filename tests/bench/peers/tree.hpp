// A scene as other programs take it: links in a tree, each on one joint, what acts on them and what holds
// them. What these programs have no twin of is refused by name. (C++17: Simbody's headers want no more.)
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct Scene;
struct System;

namespace peers {

/// A solid with those welded to it. Its frame lies on its joint: on the parent's where the joint is at zero.
struct Link {
  enum class Joint { hinge, slide, ball, free };
  std::string name;
  int parent = -1;  ///< an earlier link; -1: the world
  Joint joint = Joint::hinge;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of a hinge or slide, unit
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< the joint's place on the parent
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< m
  /// At the start: the scalar; a ball's quaternion (w, x, y, z); a free one's place, then its quaternion.
  std::vector<double> q;
  /// Its rate; the angular velocity in the link's own axes; velocity in the parent's axes, then that.
  std::vector<double> v;
  std::vector<double> a;                                    ///< v's rate at the start, by our equations
  double mass = 0;                                          ///< kg
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();         ///< of gravity, m
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();        ///< principal ones about the centre, kg m^2
  Eigen::Matrix3d principal = Eigen::Matrix3d::Identity();  ///< their axes: columns, right-handed
};

/// A point of a link (of the world: -1), m.
struct At {
  int link = -1;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

struct Spring {
  At a, b;
  double stiffness, damping, rest;  ///< N/m, N s/m, m
};
struct JointSpring {
  int link;  ///< on a hinge or slide
  double stiffness, damping, rest;
};
struct Turn {
  int link;
  Eigen::Vector3d torque;  ///< N m, world axes
};
/// Two points that are one.
struct Held {
  At a, b;
};
/// A point that stays on a plane of another link.
struct InPlane {
  At point, plane;
  Eigen::Vector3d normal;
};

/// A sphere or a box of a link that stays over a plane of the world.
struct Ground {
  At centre;
  double radius;         ///< m; of a box 0
  Eigen::Vector3d size;  ///< m, edges along the link's axes; of a sphere 0
  Eigen::Vector3d on, normal;
  double restitution, friction;
};

struct Tree {
  Eigen::Vector3d gravity;
  std::vector<Link> links;
  std::vector<Spring> springs;
  std::vector<JointSpring> joint_springs;
  std::vector<Turn> turns;
  std::vector<Held> held;
  std::vector<InPlane> in_planes;
  std::vector<Ground> grounds;
  /// Where each solid of the scene sits: its link and its frame there.
  struct Seat {
    int link = -1;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
  };
  std::vector<Seat> seats;
};

/// The scene at its start, put on its constraints.
Result<Tree> tree_of(const Scene& scene, const System& system);

/// Where links are and how they move, world axes.
struct Moving {
  Eigen::Matrix3d R;
  Eigen::Vector3d p;       ///< the frame's origin, m
  Eigen::Vector3d omega;   ///< rad/s
  Eigen::Vector3d centre;  ///< the velocity of the gravity centre, m/s
};

/// The same for programs without points on planes: where the whole tree moves in a plane, two planes across
/// it through one point hold that point. Fails with what they lack.
Result<Tree> with_held_points(const Tree& tree);

/// All links at the start, and how their motion changes there by our equations.
struct Start {
  std::vector<Moving> links;
  std::vector<Eigen::Vector3d> alpha, acceleration;  ///< rad/s^2; of the gravity centres, m/s^2
};
Start start_of(const Tree& tree);

/// kg m/s, of all links.
Eigen::Vector3d momentum(const Tree& tree, const Moving* links);

/// J: kinetic energy, and that of weight and springs. NaN where torques or springs on joints act.
double energy(const Tree& tree, const Moving* links);

/// The largest residual of what holds the links, m.
double residual(const Tree& tree, const Moving* links);

/// The points of a ground's form that can touch it: a sphere's lowest, a box's corners. m, world axes.
std::vector<Eigen::Vector3d> touching_points(const Ground& ground, const Moving& link);

/// How deep the links are in the ground at most, m.
double penetration(const Tree& tree, const Moving* links);

}  // namespace peers
}  // namespace borelli
