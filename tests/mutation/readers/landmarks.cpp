// Landmarks: our own JSON, point lists of 3D Slicer in both of its forms.
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_landmarks {

const std::string ours = R"({"frame": "LPS", "unit": "mm", "landmarks": {
 "hip_left": {"point": [80.5, -20.25, 900], "deviation": 2.0, "radius": 24.1, "source": "bone: sphere"},
 "neck": {"point": [0, 1e1, -3.5]}}})";

const std::string markups = R"({"@schema": "markups-schema-v1.0.3.json#",
 "markups": [{"type": "Fiducial", "coordinateSystem": "LPS", "coordinateUnits": "mm", "locked": false,
  "controlPoints": [
   {"id": "1", "label": "Hip-Left", "description": "", "position": [80.5, -20.25, 900.0],
    "orientation": [-1, 0, 0, 0, -1, 0, 0, 0, 1], "selected": true, "positionStatus": "defined"},
   {"id": "2", "label": "KNEE R", "position": [-90.0, 1.0, 480.0]},
   {"id": "3", "label": "ankle_left", "position": [0.0, 0.0, 0.0], "positionStatus": "undefined"}]}]})";

const std::string fcsv =
    "# Markups fiducial file version = 5.4\r\n# CoordinateSystem = LPS\r\n"
    "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\r\n"
    "vtkMRMLMarkupsFiducialNode_0,10.5,-3e1,400,0,0,0,1,1,1,0,\"Wrist, left\",,,2,0\r\n"
    "1,0,0,0,0,0,0,1,1,1,0,neck,,,0,0\r\n";

std::vector<TestCase> seeds() {
  return {{"ours", {{"a.json", ours}}},
          {"markups", {{"a.mrk.json", markups}}},
          {"markups_json", {{"a.json", markups}}},
          {"fcsv", {{"a.fcsv", fcsv}}},
          {"fcsv_old",
           {{"a.fcsv", "# columns = label,x,y,z,sel,vis\n# CoordinateSystem = 1\nxiphion,1,2,3,1,1\n"}}}};
}

Result<void> read(const std::filesystem::path& file) {
  const auto given = read_given_landmarks(file.string());
  if (given)
    for (const auto& [name, landmark] : given->all())
      if (!landmark.point.allFinite()) return defect("a landmark is nowhere: " + name);
  if (!given) return tl::unexpected(given.error());
  return {};
}

}  // namespace of_landmarks

Reader landmarks_reader() { return {"landmarks", of_landmarks::seeds, of_landmarks::read}; }

}  // namespace borelli::mutation
