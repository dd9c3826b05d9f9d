// Another program that runs a scene. (C++17, as tree.hpp.)
#pragma once

#include <functional>
#include <memory>

#include "tree.hpp"

namespace borelli::peers {

struct Method {
  std::string name;  ///< with the program's
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
  /// Through `times` (s, rising from above 0, whole steps apart). With a step of 0 the method chooses its
  /// steps by `tolerance`; else it makes steps of that length (s) alone. `go_on` is asked now and then.
  virtual Result<Run> run(std::size_t method, double step, double tolerance, const std::vector<double>& times,
                          const std::function<bool()>& go_on) = 0;
};

/// Fail with what of the tree the program has no twin of, or what it said.
Result<std::unique_ptr<Peer>> make_mujoco(const Tree& tree);
/// (of a module that is loaded with its own libraries first: see CMakeLists.txt)
extern "C" void make_simbody(const Tree& tree, Result<std::unique_ptr<Peer>>& out);
Result<std::unique_ptr<Peer>> make_dart(const Tree& tree);
Result<std::unique_ptr<Peer>> make_bullet(const Tree& tree);

/// How many steps of about `step` go into `interval`, one at least.
inline long steps_in(double interval, double step) {
  const double n = interval / step;
  return n < 1.5 ? 1 : static_cast<long>(n + 0.5);
}

}  // namespace borelli::peers
