// Generates names for unnamed parts of a model.
#pragma once

#include <set>
#include <string>

namespace borelli {

/// Generates names that differ from all before.
class UniqueNames {
 public:
  /// Registers a name that a file gives. False if it is taken.
  bool take(const std::string& name) { return taken_.insert(name).second; }

  /// `wanted`, with primes appended while it is taken.
  std::string make(std::string wanted) {
    while (!take(wanted)) wanted += "'";
    return wanted;
  }

 private:
  std::set<std::string> taken_;
};

}  // namespace borelli
