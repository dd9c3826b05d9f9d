// Inertia tables: the JSON that later stages read, and CSV.
#include <numbers>

#include "inertia/csv.hpp"
#include "inertia/table_file.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_table {

InertiaTable small_table() {
  InertiaRow thigh, trunk;
  thigh.part = "thigh_left", thigh.volume = 0.008;
  thigh.inertial = {8, {0.1, 0, 0.7}, Eigen::Vector3d(0.12, 0.12, 0.025).asDiagonal()};
  SegmentFrame frame;
  frame.segment = "thigh", frame.from = "HJC", frame.to = "KJC";
  frame.from_point << 0.1, 0, 0.9;
  frame.to_point << 0.1, 0, 0.5;
  frame.long_axis << 0, 0, -1;
  frame.R_WA << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  frame.axes = "Z along the epicondyles", frame.cuts = "zatsiorsky";
  thigh.frame = frame;
  thigh.notes = {"made by hand, \"exactly\""};
  thigh.deviations = {{"mass", 0.1, {0.06, 0.08}}};
  trunk.part = "lower_trunk", trunk.volume = 0.011, trunk.completeness = Completeness::cut;
  trunk.inertial = {11.3, {0.01, -0.05, 1.02}, Eigen::Vector3d(0.07, 0.09, 0.1).asDiagonal()};
  InertiaSource source;
  source.volume = "a.nii", source.quantity = "hu", source.sex = "male", source.frames = "joints";
  InertiaTable table = make_table(source, {thigh, trunk});
  table.causes = {"noise", "density"};
  return table;
}

std::vector<TestCase> seeds() {
  const InertiaTable table = small_table();
  return {{"json", {{"table.json", to_json(table)}}}, {"csv", {{"table.csv", to_csv(table)}}}};
}

Result<void> read(const std::filesystem::path& file) {
  if (file.extension() == ".csv") {
    const auto rows = parse_csv(bytes_of(file), file.string());
    if (!rows) return tl::unexpected(rows.error());
    for (std::size_t n = 0; n < rows->rows.size(); ++n) static_cast<void>(rows->number(n, "mass_kg"));
    return {};
  }
  const auto table = read_table(file);
  if (!table) return tl::unexpected(table.error());
  static_cast<void>(to_csv(*table));
  const auto again = table_from_json(to_json(*table), file.string());
  if (!again) return defect("what is written of it is refused: " + again.error().message());
  return {};
}

}  // namespace of_table

Reader table_reader() { return {"table", of_table::seeds, of_table::read}; }

}  // namespace borelli::mutation
