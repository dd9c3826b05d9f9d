// MJCF's sites as markers, straight tendons as springs, and the keyframe that holds a scene's start.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "dynamics/formats/mjcf_joint.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

/// The name of the keyframe that is read as the start of the scene. (Of others, such as "home", nothing says
/// that a motion starts there.)
inline constexpr const char* mjcf_start = "start";

/// Named sites of a model. A site that a tendon runs through is no marker.
class MjcfSites {
 public:
  explicit MjcfSites(const XmlElement& root);

  /// Reads the sites of a body that is this solid.
  void read(const XmlElement& body, const std::string& solid, std::vector<Marker>& markers);

  /// Adds the tendons that run straight between two sites, with a spring or damper and nothing else, as point
  /// springs. `poses`: X_WS in the model's pose, by solid; there a tendon without springlength is at rest.
  /// Other tendons stay unread.
  void add_springs(const XmlElement& root, const std::map<std::string, Pose>& poses,
                   const MjcfJoints::Acting& acting, std::vector<Effort>& efforts) const;

 private:
  std::map<std::string, SolidPoint> points_;
  std::set<std::string> on_tendons_;
};

/// Gives the coordinates the positions and velocities of the keyframe `start`, if there is one. Refuses other
/// counts of numbers than the model has.
void read_mjcf_start(const XmlElement& root, Scene& scene);

}  // namespace borelli
