// Skeletons and their motion as BVH.
#include "pipeline/recordings/bvh_motion.hpp"
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_bvh {

const std::string arm =
    "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 1 0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
    "Yrotation\n\tJOINT Arm\n\t{\n\t\tOFFSET 0.2 0 0\n\t\tCHANNELS 1 Zrotation\n\t\tEnd "
    "Site\n\t\t{\n\t\t\tOFFSET "
    "0.3 0 0\n\t\t}\n\t}\n}\nMOTION\nFrames: 2\nFrame Time: 0.5\n1 2 3 0 0 0 90\n1 2e1 -3 0 0 0 -90\n";
const std::string compact =
    "hierarchy root a { offset 0 0 0 channels 0 joint b c { channels 2 zrotation zposition offset 1 2 3 end "
    "site { "
    "offset 0 0 1 } } }\r\nROOT d { OFFSET 1 1 1 }\r\nMOTION\r\nFrames:1\r\nFrame Time:1\r\n1 2\r\n";

std::vector<TestCase> seeds() {
  std::vector<TestCase> out{{"arm", {{"a.bvh", arm}}}, {"compact", {{"a.bvh", compact}}}};
  for (TestCase& test : shared_cases({"motion/walk1.bvh"})) out.push_back(std::move(test));
  return out;
}

Result<void> read(const std::filesystem::path& file) {
  const auto motion = read_bvh(file);
  if (!motion) return tl::unexpected(motion.error());
  for (std::size_t i = 0; i < motion->joints.size(); ++i)
    if (motion->joints[i].parent >= static_cast<int>(i)) return defect("a joint before its parent");
  const auto text = bvh_text(*motion, file.string());
  if (!text) return defect("what was read cannot be written: " + text.error().message());
  const auto again = parse_bvh(*text, file.string());
  if (!again) return defect("what is written of it is refused: " + again.error().message());
  if (again->joints.size() != motion->joints.size() || again->values != motion->values ||
      again->frame_time != motion->frame_time)
    return defect("what is written of it reads otherwise");
  const auto markers = bvh_markers(*motion, guessed_bvh_unit(*motion).value_or(1), file.string());
  if (!markers) return tl::unexpected(markers.error());
  if (markers->frames.size() != markers->times.size()) return defect("not one frame at each time");
  return {};
}

}  // namespace of_bvh

Reader bvh_reader() { return {"bvh", of_bvh::seeds, of_bvh::read}; }

}  // namespace borelli::mutation
