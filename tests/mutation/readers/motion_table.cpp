// OpenSim's .mot and .sto, and SIMM's .mot.
#include "pipeline/recordings/motion_table_file.hpp"
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_motion_table {

std::vector<TestCase> seeds() {
  std::vector<TestCase> out{
      {"mot",
       {{"a.mot",
         "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n\nUnits are S.I. units (second, "
         "meters, "
         "Newtons, ...)\nAngles are in degrees.\n\nendheader\ntime\thip_r\tknee_r\n   0.0\t -1.5\t2e1\n   "
         "0.1\tnan\t4\n"}}},
      {"simm",
       {{"b.mot",
         "name walk\ndatacolumns 2\ndatarows 2\notherdata 1\nrange 0.0 0.5\nendheader\na b\n1 2\n3 4\n"}}},
      {"sto",
       {{"c.sto", "forces\t\t\r\nDataType=double\r\nversion=3\r\nendheader\r\ntime\tx\r\n0\t\r\n1\t2\r\n"}}}};
  for (TestCase& test : shared_cases({"motion/gait10dof18musc_ik.mot"})) out.push_back(std::move(test));
  return out;
}

Result<void> read(const std::filesystem::path& file) {
  const auto table = read_motion_table(file);
  if (!table) return tl::unexpected(table.error());
  const MotionTable& first = table->table;
  if (first.values.rows() != std::ssize(first.times) || first.values.cols() != std::ssize(first.columns))
    return defect("not a value for each time and column");
  const auto text = motion_table_text(first, file.string());
  if (!text) return tl::unexpected(text.error());
  const auto again = parse_motion_table(*text, file.string());
  if (!again) return defect("what is written of it is refused: " + again.error().message());
  const MotionTable& second = again->table;
  const bool same = (first.values.array() == second.values.array() ||
                     (first.values.array().isNaN() && second.values.array().isNaN()))
                        .all();
  if (!same || first.columns != second.columns || first.times != second.times || first.name != second.name ||
      first.in_degrees != second.in_degrees)
    return defect("what is written of it reads otherwise");
  return {};
}

}  // namespace of_motion_table

Reader motion_table_reader() { return {"motion_table", of_motion_table::seeds, of_motion_table::read}; }

}  // namespace borelli::mutation
