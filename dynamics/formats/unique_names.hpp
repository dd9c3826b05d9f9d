// Names for what a model leaves without one.
#pragma once

#include <set>
#include <string>

namespace borelli {

/// Hands out names that differ from all before.
class UniqueNames {
 public:
  /// Takes a name that a file gives. False if it is taken.
  bool take(const std::string& name) { return taken_.insert(name).second; }

  /// `wanted`, with primes behind it where that is taken.
  std::string make(std::string wanted) {
    while (!take(wanted)) wanted += "'";
    return wanted;
  }

 private:
  std::set<std::string> taken_;
};

}  // namespace borelli
