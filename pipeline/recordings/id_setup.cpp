#include "pipeline/recordings/id_setup.hpp"

#include <fmt/core.h>

#include <cmath>

#include "pipeline/recordings/opensim_property.hpp"

namespace borelli {
namespace {

InverseDynamicsSetup id_setup_of(const XmlElement& root) {
  const XmlElement& tool = opensim_object(root, {"InverseDynamicsTool"});
  InverseDynamicsSetup out;
  out.name = tool.text("name");
  out.model_file = property_path(tool, "model_file");
  out.coordinates_file = property_path(tool, "coordinates_file");
  out.external_loads_file = property_path(tool, "external_loads_file");
  out.results_directory = property_path(tool, "results_directory");
  if (const std::string file = property_text(tool, "output_gen_force_file"); !file.empty())
    out.output_gen_force_file = file;
  out.time_range = property_range(tool, "time_range");
  out.forces_to_exclude = property_words(tool, "forces_to_exclude");
  const double cutoff = property_number(tool, "lowpass_cutoff_frequency_for_coordinates", -1);
  if (cutoff == 0 || std::isinf(cutoff))
    tool.refuse(
        fmt::format("has the lowpass_cutoff_frequency_for_coordinates {:g}, expected Hz above zero, or a "
                    "number below zero for no filter",
                    cutoff));
  if (cutoff > 0) out.lowpass_cutoff = cutoff;
  // body forces at joints are asked for by joints; without joints the file's name says nothing
  if (property_words(tool, "joints_to_report_body_forces").empty())
    property_text(tool, "output_body_forces_file");
  else
    tool.child("joints_to_report_body_forces")->read = false;
  out.not_modelled = not_read(root);
  return out;
}

}  // namespace

Result<InverseDynamicsSetup> read_id_setup(const std::filesystem::path& path) {
  try {
    return id_setup_of(read_xml(path));
  } catch (const XmlRefusal& refusal) {
    return tl::unexpected(refusal.error);
  }
}

}  // namespace borelli
