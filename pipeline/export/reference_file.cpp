#include "pipeline/export/reference_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "error/file_ending.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

/// The fields of a line; a quoted field may contain commas.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line)
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      out.emplace_back();
    else if (c != '\r')
      out.back() += c;
  return out;
}

Result<GivenReference> from_trajectory(const std::filesystem::path& path,
                                       const std::vector<std::string>& solids) {
  const auto stored = read_trajectory(path);
  if (!stored) return tl::unexpected(stored.error());
  const Trajectory& t = stored->trajectory;
  GivenReference out{.name = path.filename().string(), .times = t.times, .poses = {}};
  std::vector<std::size_t> order;
  for (const std::string& name : solids) {
    const auto found = std::find(t.solids.begin(), t.solids.end(), name);
    if (found == t.solids.end()) return bad_use(path.string(), "has no solid '" + name + "'");
    order.push_back(std::size_t(found - t.solids.begin()));
  }
  for (std::size_t row = 0; row < t.times.size(); ++row)
    for (const std::size_t solid : order) out.poses.push_back(t.pose(row, solid));
  return out;
}

Result<GivenReference> from_csv(const std::filesystem::path& path, const std::vector<std::string>& solids) {
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  GivenReference out{.name = path.filename().string(), .times = {}, .poses = {}};
  std::vector<std::size_t> columns;  // time, then seven per solid
  std::istringstream lines(*text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line == "\r" || line.front() == '#') continue;
    const std::vector<std::string> fields = fields_of(line);
    const auto wrong = [&](const std::string& what) {
      return bad_use(fmt::format("{}:{}", path.string(), number), what);
    };
    if (columns.empty()) {
      std::vector<std::string> names{"time [s]"};
      for (const std::string& solid : solids) {
        for (const char axis : {'x', 'y', 'z'})
          names.push_back(fmt::format("position {}.{} [m]", solid, axis));
        for (const char part : {'w', 'x', 'y', 'z'})
          names.push_back(fmt::format("orientation {}.{} [1]", solid, part));
      }
      for (const std::string& name : names) {
        const auto found = std::find(fields.begin(), fields.end(), name);
        if (found == fields.end()) return wrong("has no column '" + name + "'");
        columns.push_back(std::size_t(found - fields.begin()));
      }
      continue;
    }
    std::vector<double> x;
    for (const std::size_t column : columns) {
      double value = std::nan("");
      if (column < fields.size()) {
        const std::string& field = fields[column];
        const auto read = std::from_chars(field.data(), field.data() + field.size(), value);
        if (read.ec != std::errc() || read.ptr != field.data() + field.size()) value = std::nan("");
      }
      if (!std::isfinite(value)) return wrong(fmt::format("has no number in column {}", column + 1));
      x.push_back(value);
    }
    if (!out.times.empty() && !(x[0] > out.times.back())) return wrong("times do not increase");
    out.times.push_back(x[0]);
    for (std::size_t i = 1; i < x.size(); i += 7) {
      const Quaternion q(x[i + 3], x[i + 4], x[i + 5], x[i + 6]);
      if (!(std::abs(q.norm() - 1) < 1e-3)) return wrong("contains a quaternion that is not of unit length");
      out.poses.push_back({rotation_matrix(q.normalized()), {x[i], x[i + 1], x[i + 2]}});
    }
  }
  if (out.times.empty()) return bad_use(path.string(), "contains no rows");
  return out;
}

}  // namespace

Result<GivenReference> read_reference(const std::filesystem::path& path,
                                      const std::vector<std::string>& solids) {
  if (std::error_code problem; !std::filesystem::exists(path, problem))
    return bad_use(path.string(), "no such file");
  return ending_of(path) == ".csv" ? from_csv(path, solids) : from_trajectory(path, solids);
}

}  // namespace borelli
