// Generates names for unnamed parts of a model.
#pragma once

#include <map>
#include <set>
#include <string>

namespace borelli {

/// Generates names that differ from all before.
class UniqueNames {
 public:
  /// Registers a name that a file gives. False if it is taken.
  bool take(const std::string& name) { return taken_.insert(name).second; }

  /// `wanted`; while it is taken, with primes appended: b', b'' ... From the tenth on, with one and their
  /// number (b'10), so that names stay short.
  std::string make(const std::string& wanted) {
    int& primes = primes_[wanted];
    std::string name = wanted;
    while (!take(name)) name = wanted + ending(++primes);
    return name;
  }

 private:
  static std::string ending(int primes) {
    return primes < 10 ? std::string(std::size_t(primes), '\'') : "'" + std::to_string(primes);
  }

  std::set<std::string> taken_;
  std::map<std::string, int> primes_;  // those of the last name made
};

}  // namespace borelli
