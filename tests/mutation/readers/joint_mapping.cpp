// Tables from joint names to segments.
#include "pipeline/recordings/joint_mapping.hpp"

#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_joint_mapping {

const std::string mapping =
    "# of a program\njoint\tsegment\nmixamorig:Hips\tlower_trunk\nLeft Up Leg = thigh_left\nArm   "
    "upper_arm_right\r\n";

std::vector<TestCase> seeds() { return {{"mapping", {{"a.txt", mapping}}}}; }

Result<void> read(const std::filesystem::path& file) {
  if (auto strict = read_joint_mapping(file, {"lower_trunk", "thigh_left", "upper_arm_right"}); !strict) {
    if (auto free = read_joint_mapping(file); free)
      for (const auto& [joint, segment, line] : free->entries)
        if (joint.empty() || segment.empty() || line < 1) return defect("an entry without a name");
    return tl::unexpected(strict.error());
  }
  return {};
}

}  // namespace of_joint_mapping

Reader joint_mapping_reader() { return {"joint_mapping", of_joint_mapping::seeds, of_joint_mapping::read}; }

}  // namespace borelli::mutation
