#include "pipeline/motion/motion_text.hpp"

#include "error/file_ending.hpp"
#include "pipeline/motion/bvh_skeleton.hpp"
#include "pipeline/motion/marker_paths.hpp"
#include "pipeline/recordings/trc_file.hpp"

namespace borelli {

bool is_motion_text(const std::string& file) {
  const std::string ending = ending_of(file);
  return ending == ".bvh" || ending == ".trc";
}

Result<std::string> motion_text(const Scene& scene, const Trajectory& motion, const std::string& file) {
  if (ending_of(file) == ".bvh") {
    const auto bvh = bvh_skeleton(scene, motion);
    return bvh ? bvh_text(*bvh, file) : tl::unexpected(bvh.error());
  }
  auto markers = marker_paths(scene, motion);
  if (!markers) return tl::unexpected(markers.error());
  TrcFile trc;
  trc.motion = std::move(*markers);
  return trc_text(trc, file);
}

}  // namespace borelli
