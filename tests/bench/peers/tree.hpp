// A scene for other programs: a tree of links with one joint each, the forces on them and their constraints.
// Elements that these programs lack are refused by name. C++17, because Simbody's headers need it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct Scene;
struct System;

namespace peers {

/// A solid with those welded to it. Its frame is at its joint and coincides with the joint's frame on the
/// parent when the joint is at zero.
struct Link {
  enum class Joint { hinge, slide, ball, free };
  std::string name;
  int parent = -1;  ///< an earlier link; -1: the world
  Joint joint = Joint::hinge;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of a hinge or slide, unit
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< the joint's place on the parent
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< m
  /// Positions at the start: the scalar; a ball's quaternion (w, x, y, z); a free joint's position, then its
  /// quaternion.
  std::vector<double> q;
  /// Velocities: the scalar's rate; a ball's angular velocity in the link's axes; a free joint's velocity in
  /// the parent's axes, then its angular velocity.
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
/// Two points held together.
struct Held {
  At a, b;
};
/// A point held in a plane of another link.
struct InPlane {
  At point, plane;
  Eigen::Vector3d normal;
};

/// A sphere or a box of a link that stays above a plane of the world.
struct Ground {
  At centre;
  double radius;         ///< m; 0 for a box
  Eigen::Vector3d size;  ///< edges along the link's axes, m; 0 for a sphere
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

/// The scene at its start, projected onto its constraints.
Result<Tree> tree_of(const Scene& scene, const System& system);

/// Pose and velocities of a link, world axes.
struct Moving {
  Eigen::Matrix3d R;
  Eigen::Vector3d p;       ///< the frame's origin, m
  Eigen::Vector3d omega;   ///< rad/s
  Eigen::Vector3d centre;  ///< the velocity of the gravity centre, m/s
};

/// The tree for programs without points on planes. If the whole tree moves in one plane, two planes across it
/// through one point are replaced by a held point. Fails if points on planes remain.
Result<Tree> with_held_points(const Tree& tree);

/// All links at the start, with their accelerations by our equations.
struct Start {
  std::vector<Moving> links;
  std::vector<Eigen::Vector3d> alpha, acceleration;  ///< rad/s^2; of the gravity centres, m/s^2
};
Start start_of(const Tree& tree);

/// Linear momentum of all links, kg m/s.
Eigen::Vector3d momentum(const Tree& tree, const Moving* links);

/// Kinetic energy plus the potential energy of weight and springs, J. NaN if torques or joint springs act.
double energy(const Tree& tree, const Moving* links);

/// The largest residual of the constraints, m.
double residual(const Tree& tree, const Moving* links);

/// The points of a ground's form that can touch it: a sphere's lowest, a box's corners. m, world axes.
std::vector<Eigen::Vector3d> touching_points(const Ground& ground, const Moving& link);

/// The deepest penetration of a link into the ground, m.
double penetration(const Tree& tree, const Moving* links);

}  // namespace peers
}  // namespace borelli
