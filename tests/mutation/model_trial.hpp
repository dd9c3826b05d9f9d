// The verbs' steps on a scene or a model (TOML, MJCF, URDF, OpenSim).
#pragma once

#include "tests/mutation/reader.hpp"

namespace borelli::mutation {

/// Reads, compiles, runs `info`, writes the scene and reads it again, evaluates the start and takes a few
/// steps.
Result<void> try_model(const std::filesystem::path& file);

/// An error of the engine preceded by the file's name, as the verbs print it.
tl::unexpected<Error> in_file(const std::string& file, Error error);

/// These files of `samples/`, each a case.
std::vector<TestCase> sample_cases(const std::vector<std::string>& names);
/// These files of ../shared, each a case. Absent files are left out.
std::vector<TestCase> shared_cases(const std::vector<std::string>& paths);

/// A tetrahedron, as binary STL.
std::string tetrahedron_stl();

}  // namespace borelli::mutation
