#include "pipeline/recordings/ik_setup.hpp"

#include <fmt/core.h>

#include <cmath>
#include <set>

#include "error/printable.hpp"
#include "pipeline/recordings/opensim_property.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr double most_weight = 1e12;  // sums of squares of larger ones lose the smaller ones

double weight_of(const XmlElement& task) {
  const double weight = property_number(task, "weight", 0);
  if (!(weight >= 0 && weight <= most_weight))
    task.refuse(fmt::format("has the weight {:g}, expected a number from 0 to {:g}", weight, most_weight));
  return weight;
}

CoordinateTask::Target target_of(const XmlElement& task) {
  const std::string word = property_text(task, "value_type");
  const std::string lower = lower_case(word);
  if (lower.empty() || lower == "default_value") return CoordinateTask::Target::default_value;
  if (lower == "manual_value") return CoordinateTask::Target::manual_value;
  if (lower == "from_file") return CoordinateTask::Target::from_file;
  task.refuse(fmt::format("has the value_type '{}', expected default_value, manual_value or from_file",
                          printable(word)));
}

void read_task(const XmlElement& task, InverseKinematicsSetup& out) {
  const bool of_marker = task.name == "IKMarkerTask";
  if (!of_marker && task.name != "IKCoordinateTask") return;  // listed as not read
  task.read = true;
  const std::string name = task.text("name");
  if (name.empty())
    task.refuse(fmt::format("has no name; give it that of a {}", of_marker ? "marker" : "coordinate"));
  const bool apply = property_flag(task, "apply", true);
  if (of_marker) {
    out.markers.push_back({name, apply, weight_of(task)});
    return;
  }
  const double value = property_number(task, "value", 0);
  if (std::isinf(value)) task.refuse("has an infinite value, expected a finite number");
  out.coordinates.push_back({component_name(name), apply, weight_of(task), target_of(task), value});
}

// OpenSim would follow the first or the last of two tasks for one name, by version.
void refuse_doubled(const XmlElement& set, const InverseKinematicsSetup& setup) {
  std::set<std::string> markers, coordinates;
  for (const MarkerTask& task : setup.markers)
    if (!markers.insert(task.marker).second)
      set.refuse(fmt::format("has two tasks for the marker '{}'", printable(task.marker)));
  for (const CoordinateTask& task : setup.coordinates)
    if (!coordinates.insert(task.coordinate).second)
      set.refuse(fmt::format("has two tasks for the coordinate '{}'", printable(task.coordinate)));
}

InverseKinematicsSetup ik_setup_of(const XmlElement& root) {
  // (the third name is a misspelling of OpenSim 2)
  const XmlElement& tool =
      opensim_object(root, {"InverseKinematicsTool", "IKTool", "InverseKinemtaticsTool"});
  if (const XmlElement* trials = tool.child("IKTrialSet"))
    trials->refuse("is in the format of OpenSim before 2.3; open the file in a later OpenSim and save it");
  InverseKinematicsSetup out;
  out.name = tool.text("name");
  out.model_file = property_path(tool, "model_file");
  out.marker_file = property_path(tool, "marker_file");
  out.coordinate_file = property_path(tool, "coordinate_file");
  out.results_directory = property_path(tool, "results_directory");
  out.output_motion_file = property_path(tool, "output_motion_file");
  const XmlElement* set = tool.child("IKTaskSet");
  for (const XmlElement* task : set_objects(set)) read_task(*task, out);
  if (set) refuse_doubled(*set, out);
  out.constraint_weight = property_number(tool, "constraint_weight", out.constraint_weight);
  if (out.constraint_weight < 0) tool.refuse("has a negative constraint_weight, expected 0 or more");
  out.accuracy = property_number(tool, "accuracy", out.accuracy);
  if (!(out.accuracy > 0) || std::isinf(out.accuracy))
    tool.refuse(fmt::format("has the accuracy {:g}, expected a positive number", out.accuracy));
  out.time_range = property_range(tool, "time_range");
  out.report_errors = property_flag(tool, "report_errors", out.report_errors);
  out.report_marker_locations = property_flag(tool, "report_marker_locations", out.report_marker_locations);
  out.not_modelled = not_read(root);
  return out;
}

}  // namespace

Result<InverseKinematicsSetup> read_ik_setup(const std::filesystem::path& path) {
  try {
    return ik_setup_of(read_xml(path));
  } catch (const XmlRefusal& refusal) {
    return tl::unexpected(refusal.error);
  }
}

}  // namespace borelli
