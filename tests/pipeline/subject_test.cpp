#include "pipeline/files/subject.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

ScannedVolume scan_of(const std::string& sex, std::optional<double> age) {
  ScannedVolume scan;
  scan.sex = sex, scan.age_years = age;
  return scan;
}

TEST(Subject, HeadersSexIsUsedByDefault) {
  const Subject said = subject_of(scan_of("female", 34), "");
  EXPECT_EQ(said.sex, "female");
  ASSERT_EQ(said.notes.size(), 1U);
  EXPECT_EQ(said.notes[0], "sex female comes from the DICOM header (--sex overrides it)");
  EXPECT_EQ(subject_of(scan_of("", {}), "").sex, "");
  EXPECT_TRUE(subject_of(scan_of("", {}), "male").notes.empty());
}

TEST(Subject, UserOverridesTheHeader) {
  const Subject said = subject_of(scan_of("female", 34), "male");
  EXPECT_EQ(said.sex, "male");
  ASSERT_EQ(said.notes.size(), 1U);
  EXPECT_EQ(said.notes[0], "the DICOM header says female; --sex male was used instead");
  EXPECT_TRUE(subject_of(scan_of("male", 34), "male").notes.empty());
}

TEST(Subject, ChildIsNotComparedWithAdultsByDefault) {
  const Subject alone = subject_of(scan_of("female", 7), "");
  EXPECT_EQ(alone.sex, "");
  ASSERT_EQ(alone.notes.size(), 1U);
  EXPECT_NE(alone.notes[0].find("an age of 7 years"), std::string::npos) << alone.notes[0];
  EXPECT_EQ(subject_of(scan_of("female", 7), "female").sex, "female");
}

}  // namespace
}  // namespace borelli
