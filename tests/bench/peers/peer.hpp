// Another program that runs a scene. (C++17, as tree.hpp.)
#pragma once

#include <functional>
#include <memory>

#include "tree.hpp"

namespace borelli::peers {

struct Method {
  std::string name;  ///< including the program's name
  bool adaptive = false;
};

struct Run {
  std::vector<Moving> links;  ///< [time * links + link]
  long evaluations = 0;       ///< of the accelerations
};

/// A tree in that program. Runs may be made in any order; each begins at the tree's start.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string version() const = 0;
  virtual std::vector<Method> methods() const = 0;
  /// Runs through `times` (s, increasing, above 0, whole steps apart). With a step of 0 the method chooses
  /// its steps by `tolerance`; else all steps have that length (s). The run stops when `go_on` returns false.
  virtual Result<Run> run(std::size_t method, double step, double tolerance, const std::vector<double>& times,
                          const std::function<bool()>& go_on) = 0;
};

/// Each fails if the program lacks an element of the tree, or with the program's own message.
Result<std::unique_ptr<Peer>> make_mujoco(const Tree& tree);
/// From a module loaded with its own libraries first (see CMakeLists.txt).
extern "C" void make_simbody(const Tree& tree, Result<std::unique_ptr<Peer>>& out);
Result<std::unique_ptr<Peer>> make_dart(const Tree& tree);
Result<std::unique_ptr<Peer>> make_bullet(const Tree& tree);

/// The number of steps of about `step` in `interval`, at least 1.
inline long steps_in(double interval, double step) {
  const double n = interval / step;
  return n < 1.5 ? 1 : static_cast<long>(n + 0.5);
}

}  // namespace borelli::peers
