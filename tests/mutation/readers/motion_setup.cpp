// OpenSim's set-ups of inverse kinematics and inverse dynamics.
#include <cmath>

#include "pipeline/recordings/id_setup.hpp"
#include "pipeline/recordings/ik_setup.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_motion_setup {

const std::string ik = R"(<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="30000"><InverseKinematicsTool name="walk"><results_directory>./</results_directory>
  <model_file> ../subject.osim </model_file><constraint_weight>Inf</constraint_weight><accuracy>1e-005</accuracy>
  <IKTaskSet><objects>
    <IKMarkerTask name="R.ASIS"><apply>true</apply><weight>3</weight></IKMarkerTask>
    <IKMarkerTask name="L.ASIS"><apply>false</apply></IKMarkerTask>
    <IKCoordinateTask name="mtp_r"><weight>1000</weight><value_type>manual_value</value_type><value>-0.5</value>
    </IKCoordinateTask></objects><groups/></IKTaskSet>
  <marker_file>walk.trc</marker_file><coordinate_file>Unassigned</coordinate_file><time_range> 0 2.5</time_range>
  <report_errors>true</report_errors><output_motion_file>ik.mot</output_motion_file>
</InverseKinematicsTool></OpenSimDocument>
)";
const std::string id = R"(<InverseDynamicsTool name="walk"><model_file>a.osim</model_file>
  <time_range>0.5 Inf</time_range><forces_to_exclude> Muscles actuators</forces_to_exclude>
  <external_loads_file>grf.xml</external_loads_file><coordinates_file>..\ik.mot</coordinates_file>
  <lowpass_cutoff_frequency_for_coordinates>6</lowpass_cutoff_frequency_for_coordinates></InverseDynamicsTool>
)";

std::vector<TestCase> seeds() { return {{"ik", {{"ik.xml", ik}}}, {"id", {{"id.xml", id}}}}; }

Result<void> read(const std::filesystem::path& file) {
  const auto kinematics = read_ik_setup(file);
  if (kinematics) {
    for (const MarkerTask& task : kinematics->markers)
      if (!(task.weight >= 0) || task.marker.empty()) return defect("a task without a marker or a weight");
    for (const CoordinateTask& task : kinematics->coordinates)
      if (!(task.weight >= 0) || !std::isfinite(task.value))
        return defect("a task without a weight or a value");
    return {};
  }
  const auto dynamics = read_id_setup(file);
  if (!dynamics) return tl::unexpected(file.filename() == "ik.xml" ? kinematics.error() : dynamics.error());
  if (!(dynamics->time_range.first <= dynamics->time_range.second)) return defect("a range that is none");
  return {};
}

}  // namespace of_motion_setup

Reader motion_setup_reader() { return {"motion_setup", of_motion_setup::seeds, of_motion_setup::read}; }

}  // namespace borelli::mutation
