// Where the tests find what they read and run. Not in the compiler's command line, so that the objects of the
// tests are the same in every checkout and ccache knows them.
#pragma once

#include <string>

namespace borelli::test {

std::string source_folder();  // this checkout
std::string shared_folder();  // files that the tests read where they are there (a test skips, saying so,
                              // where they are not)
std::string program_path();   // the built program
std::string doc_examples();   // the files that docs/adding_a_kind.md shows

}  // namespace borelli::test
