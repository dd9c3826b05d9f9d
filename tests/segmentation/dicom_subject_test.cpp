// Sex and age of the patient as DICOM headers hold them.
#include <gtest/gtest.h>

#include <tuple>

#include "dicom_series.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {
namespace {

// Codes of PS3.3, C.7.1.1 and ages of PS3.5, 6.2, as writers leave them.
TEST(DicomFolder, GivesSexAndAgeOfThePatient) {
  const std::tuple<const char*, const char*, const char*, double> cases[] = {
      {"M", "034Y", "male", 34}, {"F ", "006M", "female", 0.5},
      {"f", "52", "female", 52}, {"O", "010W", "", 10 / 52.18},
      {"", "", "", -1},          {"M", "ABC", "male", -1}};
  for (const auto& [code, age, sex, years] : cases) {
    ScratchFolder folder;
    for (int k = 0; k < 4; ++k) {
      TestSlice slice;
      slice.instance = "1.2.3.4." + std::to_string(k);
      slice.position = Eigen::Vector3d(0, 0, 3 * k);
      slice.patient_sex = code, slice.patient_age = age;
      slice.pixels.assign(30, static_cast<std::uint16_t>(k == 0 ? 0 : 1064));
      write_slice(folder / (std::to_string(k) + ".dcm"), slice);
    }
    const auto read = read_volume(folder.path());
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->sex, sex) << code;
    ASSERT_EQ(read->age_years.has_value(), years >= 0) << age;
    if (years >= 0) {
      EXPECT_NEAR(*read->age_years, years, 1e-12);
    }
  }
}

}  // namespace
}  // namespace borelli
