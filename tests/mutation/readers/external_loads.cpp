// OpenSim's external loads: an XML file and its table.
#include "pipeline/recordings/external_loads.hpp"

#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_external_loads {

const std::string table =
    "grf\nversion=1\nendheader\ntime\tf_vx\tf_vy\tf_vz\tf_px\tf_py\tf_pz\tm1\tm2\tm3\n"
    "0\t1\t2\t3\t4\t5\t6\t7\t8\t9\n0.1\t10\t20\t30\tnan\tnan\tnan\t70\t80\t90\n";
const std::string loads = R"(<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="30000"><ExternalLoads name="walk"><objects>
  <ExternalForce name="right"><isDisabled>false</isDisabled><applied_to_body>calcn_r</applied_to_body>
    <force_expressed_in_body>ground</force_expressed_in_body><force_identifier>f_v</force_identifier>
    <point_identifier>f_p</point_identifier><torque_identifier>m</torque_identifier></ExternalForce>
  <ExternalForce name="left"><appliesForce>false</appliesForce><applied_to_body>/bodyset/calcn_l</applied_to_body>
    <force_identifier>f_v</force_identifier></ExternalForce></objects><groups/>
  <datafile>grf.mot</datafile></ExternalLoads></OpenSimDocument>
)";
const std::string bare =
    "<ExternalLoads><ExternalForce name=\"a\"><applied_to_body>b</applied_to_body><torque_identifier>m"
    "</torque_identifier></ExternalForce><datafile>grf.mot</datafile></ExternalLoads>";

std::vector<TestCase> seeds() {
  return {{"loads", {{"a.xml", loads}, {"grf.mot", table}}}, {"bare", {{"a.xml", bare}, {"grf.mot", table}}}};
}

Result<void> read(const std::filesystem::path& file) {
  const auto read = read_external_loads(file);
  if (!read) return tl::unexpected(read.error());
  for (const ExternalLoad& load : read->loads) {
    const auto count = std::ssize(load.measured.times);
    if (load.measured.force.cols() != count || load.measured.point.cols() != count ||
        load.measured.moment.cols() != count)
      return defect("not one force at each time");
    if (load.body.empty() || load.force_body.empty() || load.point_body.empty())
      return defect("a load on no body");
  }
  return {};
}

}  // namespace of_external_loads

Reader external_loads_reader() {
  return {"external_loads", of_external_loads::seeds, of_external_loads::read};
}

}  // namespace borelli::mutation
