// What the verbs do with a scene or a model of any kind.
#pragma once

#include "tests/mutation/reader.hpp"

namespace borelli::mutation {

/// Says what `info` says; reads, compiles, evaluates at the start, and moves by a few steps.
Result<void> try_model(const std::filesystem::path& file);

/// An error of the engine with the file before it, as the verbs say it.
tl::unexpected<Error> in_file(const std::string& file, Error error);

/// A file of `samples/`, or of ../shared where it is there, as a case; else nothing.
std::vector<TestCase> sample_cases(const std::vector<std::string>& names);
std::vector<TestCase> shared_cases(const std::vector<std::string>& paths);

/// A tetrahedron, as binary STL.
std::string tetrahedron_stl();

}  // namespace borelli::mutation
