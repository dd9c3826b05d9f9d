// The manual page and the shell completion, both made from the declared options.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace borelli {

/// The program's manual page, section 1, in troff with the man macros (man-pages(7)).
std::string manual_page(const CLI::App& program, const std::string& version);

/// A script for bash that completes verbs, options, and values of options that take one of a list. Other
/// words complete to files.
std::string bash_completion(const CLI::App& program);

}  // namespace borelli
