// C3D: all processors, integers and floating-point numbers, all types of force plates, events, model outputs.
#include "pipeline/recordings/c3d_file.hpp"
#include "tests/mutation/reader.hpp"
#include "tests/pipeline/recordings/c3d_writer.hpp"

namespace borelli::mutation {
namespace of_c3d {

using test::C3dWriter;

C3dWriter recording(C3dWriter::Processor processor, bool real, int type) {
  C3dWriter writer;
  writer.processor = processor, writer.real = real;
  writer.samples = 2, writer.channels = 8, writer.first_frame = 3;
  writer.frames.assign(6, {{100, 200, 900, 2}, {1, 2, 3, -1}, {30, 0, 0, 0}});
  writer.numbers.assign(12, {5, -4, -700, 30, 2000, -90, 8, 9});
  writer.header_events = {{0.02, "RHS"}};
  writer.usual_parameters({"LASI", "RASI", "LKneeAngles"});
  writer.text("POINT:ANGLES", {"LKneeAngles"});
  writer.line("POINT:Y_SCREEN", "+Z");
  writer.text("ANALOG:UNITS", {"N", "N", "N", "Nmm", "Nmm", "Nmm", "V", "V"});
  writer.reals("ANALOG:SCALE", std::vector<double>(8, 1), {8});
  writer.integers("ANALOG:OFFSET", std::vector<int>(8, 0), {8});
  writer.integer("FORCE_PLATFORM:USED", 1);
  writer.integers("FORCE_PLATFORM:TYPE", {type}, {1});
  writer.integers("FORCE_PLATFORM:ZERO", {1, 2}, {2});
  writer.reals("FORCE_PLATFORM:CORNERS", {500, 400, 0, 0, 400, 0, 0, 0, 0, 500, 0, 0}, {3, 4, 1});
  writer.reals("FORCE_PLATFORM:ORIGIN", {120, 200, -40}, {3, 1});
  writer.integers("FORCE_PLATFORM:CHANNEL", {1, 2, 3, 4, 5, 6, 7, 8}, {8, 1});
  std::vector<double> identity(36, 0);
  for (std::size_t i = 0; i < 6; ++i) identity[7 * i] = 1;
  writer.reals("FORCE_PLATFORM:CAL_MATRIX", identity, {6, 6, 1});
  writer.integer("EVENT:USED", 1);
  writer.reals("EVENT:TIMES", {0, 0.05}, {2, 1});
  writer.text("EVENT:LABELS", {"Foot Off"});
  writer.integers("TRIAL:ACTUAL_START_FIELD", {3, 0}, {2});
  writer.integers("TRIAL:ACTUAL_END_FIELD", {8, 0}, {2});
  return writer;
}

std::vector<TestCase> seeds() {
  std::vector<TestCase> out;
  const std::pair<const char*, C3dWriter::Processor> processors[] = {
      {"intel", C3dWriter::intel}, {"dec", C3dWriter::dec}, {"mips", C3dWriter::mips}};
  int type = 0;
  for (const auto& [name, processor] : processors)
    for (const bool real : {false, true}) {
      type = type % 4 + 1;
      out.push_back({std::string(name) + (real ? "_real" : "_integer"),
                     {{"a.c3d", recording(processor, real, type).bytes()}}});
    }
  C3dWriter unsigned_numbers = recording(C3dWriter::intel, false, 2);
  unsigned_numbers.line("ANALOG:FORMAT", "UNSIGNED");
  unsigned_numbers.group_order = "last", unsigned_numbers.locked = true;
  out.push_back({"unsigned", {{"a.c3d", unsigned_numbers.bytes()}}});
  return out;
}

Result<void> read(const std::filesystem::path& path) {
  const auto file = read_c3d(path);
  if (!file) return tl::unexpected(file.error());
  const std::size_t frames = file->markers.times.size();
  if (file->markers.frames.size() != frames) return defect("not one set of markers per time");
  for (std::size_t i = 0; i < frames; ++i) {
    if (file->markers.frames[i].cols() != static_cast<Eigen::Index>(file->markers.names.size()))
      return defect("not one point per marker");
    if (i > 0 && !(file->markers.times[i] > file->markers.times[i - 1]))
      return defect("times do not increase");
  }
  for (const ModelOutput& output : file->outputs)
    if (output.values.cols() != static_cast<Eigen::Index>(frames)) return defect("not one output per frame");
  for (const AnalogChannel& channel : file->analog)
    if (channel.values.size() != static_cast<Eigen::Index>(file->analog_times.size()))
      return defect("not one number per analog time");
  for (const MeasuredForce& force : file->forces)
    for (const Eigen::Matrix3Xd* values : {&force.force, &force.point, &force.moment})
      if (values->cols() != static_cast<Eigen::Index>(force.times.size()))
        return defect("not one force per time");
  return {};
}

}  // namespace of_c3d

Reader c3d_reader() { return {"c3d", of_c3d::seeds, of_c3d::read}; }

}  // namespace borelli::mutation
