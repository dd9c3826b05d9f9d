// What a stage answers when it cannot do what was asked: one sentence a user can act on.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace borelli {

struct Error {
  /// `use`: the request itself is wrong (unknown key, missing file; exit code 2). `failure`: the request was
  /// understood and could not be carried out (damaged data, divergence, disk full; exit code 1).
  enum class Kind { use, failure };

  std::string where;  ///< file, file:line, solid, joint or constraint that the error is about
  std::string what;   ///< what was found, what was expected, what to do
  Kind kind = Kind::failure;

  std::string message() const { return where.empty() ? what : where + ": " + what; }
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(std::string where, std::string what) {
  return tl::unexpected<Error>(Error{std::move(where), std::move(what), Error::Kind::failure});
}

inline tl::unexpected<Error> bad_use(std::string where, std::string what) {
  return tl::unexpected<Error>(Error{std::move(where), std::move(what), Error::Kind::use});
}

}  // namespace borelli
