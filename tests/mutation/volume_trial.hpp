// What the verbs do first with a volume.
#pragma once

#include <functional>
#include <string>

#include "segmentation/volume.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {

/// Reads it as CT numbers, and says what `info` says, as JSON and as text.
Result<void> try_volume(const std::filesystem::path& path);

/// A grid of a few voxels, oblique where asked, and CT numbers of air, flesh and bone on it.
GreyVolume small_volume(bool oblique);

/// The bytes of a file that `write` leaves at the path it is given, by its name.
std::string written(const std::string& name, const std::function<Result<void>(const std::string&)>& write);

/// RFC 1952
std::string gzipped(const std::string& bytes);

}  // namespace borelli::mutation
