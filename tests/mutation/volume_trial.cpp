#include "tests/mutation/volume_trial.hpp"

#include <stdlib.h>
#include <zlib.h>

#include <functional>
#include <stdexcept>

#include "segmentation/files/read.hpp"

namespace borelli::mutation {

namespace fs = std::filesystem;

Result<void> try_volume(const fs::path& path) {
  const auto read = read_volume(path.string(), {FileQuantity::hu, {}});
  if (read) {
    const Grid& grid = read->volume.grid;
    if (grid.count() != read->volume.voxels.size() || grid.count() == 0)
      return defect("the grid has another number of voxels than are there");
    if (!(grid.voxel_volume() > 0) || !grid.origin.allFinite()) return defect("the grid has no volume");
  }
  const auto info = run_verb({"info", path.string()});
  if (!read) return tl::unexpected(read.error());
  if (!info) return info;
  return {};
}

GreyVolume small_volume(bool oblique) {
  GreyVolume volume;
  volume.grid.size = {5, 4, 3};
  volume.grid.axes = Eigen::Vector3d(1.5, 2, 2.5).asDiagonal();
  if (oblique)
    volume.grid.axes =
        (Eigen::Matrix3d() << 0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1).finished() * volume.grid.axes;
  volume.grid.origin = {-12, 3.5, 100};
  for (std::size_t n = 0; n < volume.grid.count(); ++n)
    volume.voxels.push_back(static_cast<std::int16_t>(n % 7 == 0   ? -1000
                                                      : n % 5 == 0 ? 700
                                                                   : 30 + static_cast<int>(n)));
  return volume;
}

std::string written(const std::string& name, const std::function<Result<void>(const std::string&)>& write) {
  std::string folder = (fs::temp_directory_path() / "borelli-seed-XXXXXX").string();
  if (!mkdtemp(folder.data())) throw std::runtime_error("no folder " + folder);
  const auto done = write((fs::path(folder) / name).string());
  const std::string bytes = done ? bytes_of(fs::path(folder) / name) : "";
  fs::remove_all(folder);
  if (!done) throw std::runtime_error(done.error().message());
  return bytes;
}

std::string gzipped(const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 1000 + 100, '\0');
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

}  // namespace borelli::mutation
