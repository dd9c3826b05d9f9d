// The first steps of verbs on a volume.
#pragma once

#include <functional>
#include <string>

#include "segmentation/volume/volume.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {

/// Reads it as CT numbers, checks its grid and runs `info`.
Result<void> try_volume(const std::filesystem::path& path);

/// A few voxels with CT numbers of air, flesh and bone.
GreyVolume small_volume(bool oblique);

/// The bytes of the file `name` that `write` writes. Throws if it fails.
std::string written(const std::string& name, const std::function<Result<void>(const std::string&)>& write);

/// The bytes as gzip (RFC 1952).
std::string gzipped(const std::string& bytes);

}  // namespace borelli::mutation
