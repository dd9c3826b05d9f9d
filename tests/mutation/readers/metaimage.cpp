// MetaImage in one file and two; voxels raw and by zlib; a list of slices.
#include "segmentation/files/write.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_metaimage {

const std::string head =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
    "CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -1 2 3.5\n"
    "CenterOfRotation = 0 0 0\nAnatomicalOrientation = RAI\nElementSpacing = 2 2 3\nDimSize = 2 2 1\n"
    "ElementType = MET_SHORT\n";
const std::string voxels("\x18\xfc\0\0\x28\0\xb8\x0b", 8);

std::vector<TestCase> seeds() {
  const auto ours = [](bool oblique) {
    return written("a.mha",
                   [&](const std::string& path) { return write_volume(path, small_volume(oblique)); });
  };
  return {{"ours", {{"a.mha", ours(false)}}},
          {"oblique", {{"a.mha", ours(true)}}},
          {"raw", {{"a.mha", head + "ElementDataFile = LOCAL\n" + voxels}}},
          {"two_files",
           {{"a.mhd", head + "HeaderSize = -1\nElementDataFile = v.raw\n"}, {"v.raw", "abc" + voxels}}},
          {"list", {{"a.mhd", head + "ElementDataFile = LIST\nv0.raw\n"}, {"v0.raw", voxels}}, true}};
}

}  // namespace of_metaimage

Reader metaimage_reader() { return {"metaimage", of_metaimage::seeds, try_volume}; }

}  // namespace borelli::mutation
