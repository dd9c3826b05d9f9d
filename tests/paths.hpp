// Paths of the tests' inputs and program. They are not in the compiler's command line, so that all checkouts
// share ccache's objects.
#pragma once

#include <string>

namespace borelli::test {

std::string source_folder();  // this checkout
std::string shared_folder();  // files that the tests read where they are there (a test skips, saying so,
                              // where they are not)
std::string program_path();   // the built program
std::string doc_examples();   // the files that docs/adding_a_kind.md shows

}  // namespace borelli::test
