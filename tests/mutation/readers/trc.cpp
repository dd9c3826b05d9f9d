// Marker positions as TRC.
#include "pipeline/recordings/trc_file.hpp"
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_trc {

const std::string tabs =
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100.00\t100.00\t3\t2\tmm\t100.00\t1\t3\nFrame#\tTime\tLASI\t\t\tRASI\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    "1\t0.00\t1.5\t-2e1\t3\t4\t5\t6\n2\t0.01\t\t\t\tNaN\tnan\tNaN\n3\t0.02\t7\t8\t9\n";
const std::string blanks =
    "PathFileType 3 (X/Y/Z) a\r\nDataRate CameraRate NumFrames NumMarkers Units\r\n50 50 1 1 m\r\n"
    "Frame# Time C7\r\n X1 Y1 Z1\r\n1 0.0 1 2 3\r\n";

std::vector<TestCase> seeds() {
  std::vector<TestCase> out{{"tabs", {{"a.trc", tabs}}}, {"blanks", {{"a.trc", blanks}}}};
  for (TestCase& test : shared_cases({"motion/gait10dof18musc_walk.trc"})) out.push_back(std::move(test));
  return out;
}

Result<void> read(const std::filesystem::path& file) {
  const auto trc = read_trc(file);
  if (!trc) return tl::unexpected(trc.error());
  const MarkerMotion& motion = trc->motion;
  if (motion.frames.size() != motion.times.size()) return defect("not one frame at each time");
  for (const auto& frame : motion.frames) {
    if (frame.cols() != std::ssize(motion.names)) return defect("not one place for each marker");
    for (const auto& place : frame.colwise())
      if (!place.allFinite() && !place.array().isNaN().all()) return defect("a marker that is half there");
  }
  const auto text = trc_text(*trc, file.string());
  if (!text) return tl::unexpected(text.error());
  const auto again = parse_trc(*text, file.string());
  if (!again) return defect("what is written of it is refused: " + again.error().message());
  if (again->motion.names != motion.names || again->motion.times != motion.times)
    return defect("what is written of it reads otherwise");
  return {};
}

}  // namespace of_trc

Reader trc_reader() { return {"trc", of_trc::seeds, of_trc::read}; }

}  // namespace borelli::mutation
