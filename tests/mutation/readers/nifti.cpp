// NIfTI in one file, plain and gzip; in both byte orders and of other kinds of voxels; as a pair.
#include <cstring>

#include "segmentation/files/write.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_nifti {

template <class T>
void put(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

// Floats with a slope, qform alone (nifti1.h).
std::string floats(const std::string& plain) {
  std::string bytes = plain.substr(0, 352);
  put<std::int16_t>(bytes, 70, 16), put<std::int16_t>(bytes, 72, 32);
  put<float>(bytes, 112, 2), put<float>(bytes, 116, -100);
  put<std::int16_t>(bytes, 252, 1), put<std::int16_t>(bytes, 254, 0);
  for (int n = 0; n < 60; ++n) {
    const float value = n % 7 == 0 ? -450 : 20 + float(n);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return bytes;
}

std::vector<TestCase> seeds() {
  const auto write = [](bool oblique) {
    return written("a.nii",
                   [&](const std::string& path) { return write_volume(path, small_volume(oblique)); });
  };
  const std::string plain = write(false);
  std::string head = plain.substr(0, 348);
  std::memcpy(head.data() + 344, "ni1", 4);
  put<float>(head, 108, 0);
  return {{"plain", {{"a.nii", plain}}},
          {"oblique", {{"a.nii", write(true)}}},
          {"floats", {{"a.nii", floats(plain)}}},
          {"gzip", {{"a.nii.gz", plain, gzipped}}},
          {"pair", {{"a.hdr", head}, {"a.img", plain.substr(352)}}, true}};
}

}  // namespace of_nifti

Reader nifti_reader() { return {"nifti", of_nifti::seeds, try_volume}; }

}  // namespace borelli::mutation
