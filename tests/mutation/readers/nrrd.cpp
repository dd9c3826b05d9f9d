// NRRD, attached and detached; voxels raw, gzip, bzip2 and as text.
#include "segmentation/files/write.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_nrrd {

const std::string head =
    "NRRD0004\n# by hand\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 1\n"
    "space directions: (2,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\nkinds: domain domain domain\n"
    "endian: little\n";
const std::string voxels("\x18\xfc\0\0\x28\0\xb8\x0b", 8);  // -1000, 0, 40, 3000

std::vector<TestCase> seeds() {
  std::vector<TestCase> out;
  out.push_back({"ours", {{"a.nrrd", written("a.nrrd", [](const std::string& path) {
                             return write_volume(path, small_volume(true));
                           })}}});
  out.push_back({"raw", {{"a.nrrd", head + "encoding: raw\nborelli:=x\n\n" + voxels}}});
  out.push_back({"detached",
                 {{"a.nhdr", head + "encoding: raw\ndata file: v.raw\nbyte skip: 2\nline skip: 1\n"},
                  {"v.raw", "line\nxy" + voxels}}});
  out.push_back(
      {"detached_gzip", {{"a.nhdr", head + "encoding: gzip\ndata file: v.gz\n"}, {"v.gz", voxels, gzipped}}});
  out.push_back({"text", {{"a.nrrd", head + "encoding: text\n\n-1000 0\n40 3000\n"}}, true});
  out.push_back({"spacings",
                 {{"a.nrrd",
                   "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\nspacings: 2 2 3\nendian: little\n"
                   "space units: \"mm\" \"mm\" \"mm\"\nthicknesses: NaN NaN 3\nencoding: raw\n\n" +
                       voxels}},
                 true});
  out.push_back({"list",
                 {{"a.nhdr",
                   "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nspacings: 2 2 3\n"
                   "endian: little\nencoding: raw\ndata file: LIST\nv0.raw\nv1.raw\n"},
                  {"v0.raw", voxels.substr(0, 4)},
                  {"v1.raw", voxels.substr(4)}},
                 true});
  return out;
}

}  // namespace of_nrrd

Reader nrrd_reader() { return {"nrrd", of_nrrd::seeds, try_volume}; }

}  // namespace borelli::mutation
