#include "pipeline/recordings/external_loads.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <optional>

#include "error/printable.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/opensim_property.hpp"
#include "process/memory.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr std::size_t most_loads = 1000;

// Which axis the end of a name says: 0 to 2; -1: none.
int axis_at_end_of(std::string_view ending) {
  if (ending.empty()) return -1;
  constexpr std::string_view letters = "xyz", digits = "123";
  const char last = lower_case(ending).back();
  const std::size_t letter = letters.find(last), digit = digits.find(last);
  return letter != letters.npos ? static_cast<int>(letter)
         : digit != digits.npos ? static_cast<int>(digit)
                                : -1;
}

// Whether the rest of a name after the identifier is an axis alone.
bool is_axis_alone(std::string_view ending) {
  if (ending.starts_with('.') || ending.starts_with('_')) ending.remove_prefix(1);
  return ending.size() == 1 && axis_at_end_of(ending) >= 0;
}

// The three columns by the axes that their endings say, if these are three different ones.
std::optional<IdentifiedColumns> by_axis(const MotionTable& table, std::size_t length,
                                         const std::vector<Eigen::Index>& found) {
  if (found.size() != 3) return std::nullopt;
  IdentifiedColumns out{{-1, -1, -1}, true};
  for (const Eigen::Index i : found) {
    const int axis =
        axis_at_end_of(std::string_view(table.columns[static_cast<std::size_t>(i)]).substr(length));
    if (axis < 0 || out.column[axis] >= 0) return std::nullopt;
    out.column[axis] = i;
  }
  return out;
}

class LoadsReader {
 public:
  LoadsReader(const MotionTable& table, ExternalLoads& out) : table_(table), out_(out) {}

  void read(const XmlElement& element) {
    element.read = true;
    const std::string name = element.text("name");
    const bool disabled = property_flag(element, "isDisabled", false);
    const bool applies = property_flag(element, "appliesForce", !disabled);
    ExternalLoad load;
    load.measured.name = name;
    load.body = component_name(property_text(element, "applied_to_body"));
    load.force_body = component_name(property_text(element, "force_expressed_in_body", "ground"));
    load.point_body = component_name(property_text(element, "point_expressed_in_body", "ground"));
    const std::string force = property_text(element, "force_identifier");
    const std::string point = property_text(element, "point_identifier");
    const std::string torque = property_text(element, "torque_identifier");
    property_text(element, "data_source_name");  // the table's title: the datafile goes before it
    if (!applies) {
      out_.disabled.push_back(name);
      return;
    }
    if (load.body.empty()) element.refuse("has no applied_to_body; name the body that it acts on");
    if (force.empty() && torque.empty())
      element.refuse("has neither a force_identifier nor a torque_identifier; give at least one");
    if (force.empty() && !point.empty())
      element.refuse("has a point_identifier but no force_identifier; give both");
    if (load.force_body.empty()) load.force_body = "ground";
    if (point.empty())
      load.point_body = load.body;
    else if (load.point_body.empty())
      load.point_body = "ground";
    load.measured.times = table_.times;
    load.measured.force = vectors(element, force);
    load.measured.point = vectors(element, point);
    load.measured.moment = vectors(element, torque);
    warn_of_gaps(load);
    out_.loads.push_back(std::move(load));
  }

 private:
  // #3 by #times; zero without an identifier.
  Eigen::Matrix3Xd vectors(const XmlElement& element, const std::string& identifier) {
    Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, std::ssize(table_.times));
    if (identifier.empty()) return out;
    const auto columns = identified_columns(table_, identifier, element.where());
    if (!columns) throw XmlRefusal{columns.error()};
    for (int axis = 0; axis < 3; ++axis) out.row(axis) = table_.values.col(columns->column[axis]).transpose();
    if (!columns->in_order)
      out_.warnings.push_back(fmt::format(
          "The columns of '{}' do not end in x, y, z or 1, 2, 3; they were read in the table's order.",
          printable(identifier)));
    return out;
  }

  void warn_of_gaps(const ExternalLoad& load) {
    const auto gaps = [](const Eigen::Matrix3Xd& values) { return values.array().isNaN().colwise().any(); };
    Eigen::Index count = 0;
    const auto force = gaps(load.measured.force).eval(), moment = gaps(load.measured.moment).eval();
    for (Eigen::Index i = 0; i < std::max(force.size(), moment.size()); ++i)
      count += (i < force.size() && force[i]) || (i < moment.size() && moment[i]);
    if (count > 0)
      out_.warnings.push_back(
          fmt::format("The force or moment of '{}' is not a number in {} rows; no load acts there.",
                      printable(load.measured.name), count));
  }

  const MotionTable& table_;
  ExternalLoads& out_;
};

Result<ExternalLoads> read_loads(const XmlElement& root, const std::filesystem::path& given) {
  const XmlElement& object = opensim_object(root, {"ExternalLoads"});
  ExternalLoads out;
  out.name = object.text("name");
  std::vector<const XmlElement*> forces;
  for (const XmlElement* element : set_objects(&object)) {
    if (element->name == "PrescribedForce")
      element->refuse(
          "is in the format of OpenSim before 2.3.1; open the file in a later OpenSim and save it");
    if (element->name == "ExternalForce") forces.push_back(element);
  }
  out.data_file = property_path(object, "datafile");
  if (!given.empty()) out.data_file = given;
  if (out.data_file.empty()) object.refuse("has no datafile; name the table of its forces");
  const auto table = read_motion_table(out.data_file);
  if (!table)
    throw XmlRefusal{
        Error{object.where(), "its table cannot be read: " + table.error().message(), table.error().kind}};
  for (const std::string& warning : table->warnings)
    out.warnings.push_back(fmt::format("{}: {}", out.data_file.string(), warning));
  if (forces.size() > most_loads)
    object.refuse(fmt::format("contains {} loads, expected at most {}", forces.size(), most_loads));
  const double bytes =
      80.0 * static_cast<double>(forces.size()) * static_cast<double>(table->table.times.size());
  if (auto fits = admit_memory(object.where(), "its loads", bytes); !fits) throw XmlRefusal{fits.error()};
  LoadsReader reader(table->table, out);
  for (const XmlElement* force : forces) reader.read(*force);
  if (out.loads.empty() && out.disabled.empty())
    object.refuse("contains no <ExternalForce>, expected at least one");
  out.not_modelled = not_read(root);
  return out;
}

}  // namespace

Result<IdentifiedColumns> identified_columns(const MotionTable& table, const std::string& identifier,
                                             const std::string& where) {
  std::vector<Eigen::Index> found, exact_ones;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string_view name = table.columns[i];
    if (!name.starts_with(identifier)) continue;
    found.push_back(static_cast<Eigen::Index>(i));
    names.push_back(printable(name));
    if (is_axis_alone(name.substr(identifier.size()))) exact_ones.push_back(static_cast<Eigen::Index>(i));
  }
  if (const auto ordered = by_axis(table, identifier.size(), found)) return *ordered;
  if (const auto ordered = by_axis(table, identifier.size(), exact_ones)) return *ordered;
  if (found.size() == 3) return IdentifiedColumns{{found[0], found[1], found[2]}, false};
  return bad_use(where, fmt::format("the identifier '{}' fits {} columns of the table{}, expected three",
                                    printable(identifier), found.size(),
                                    names.empty() ? "" : " (" + name_list(names, 6) + ")"));
}

Result<ExternalLoads> read_external_loads(const std::filesystem::path& path,
                                          const std::filesystem::path& table) {
  try {
    const XmlElement root = read_xml(path);
    return read_loads(root, table);
  } catch (const XmlRefusal& refusal) {
    return tl::unexpected(refusal.error);
  }
}

}  // namespace borelli
