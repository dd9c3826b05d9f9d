#include "pipeline/files/input_names.hpp"

#include <gtest/gtest.h>

#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

TEST(InputNames, RemovesFoldersFromTexts) {
  const TestFolder folder;
  std::filesystem::create_directories(folder / "DOE_JANE/slices");
  const std::string scan = folder.write("DOE_JANE/ct.nii.gz", ""), slices = folder / "DOE_JANE/slices",
                    own = folder.path();
  const InputNames names(false, {scan, slices + "/", "", "totalsegmentator"});
  EXPECT_EQ(names.name_of(scan), "ct.nii.gz");
  EXPECT_EQ(names.name_of(slices), "DICOM folder");
  EXPECT_EQ(names.name_of(""), "");
  EXPECT_EQ(names.without_folders(scan + ": odd; see " + own + "/DOE_JANE/ct.json and '" + slices + "'"),
            "ct.nii.gz: odd; see ct.json and 'DICOM folder'");
  EXPECT_EQ(names.without_folders(slices + "/1.dcm, " + slices + "/deep/2.dcm: two"),
            "1.dcm, deep/2.dcm: two");
  const nlohmann::json value{{"mass", 3}, {"warnings", {scan + ": odd", "kg/m3"}}};
  EXPECT_EQ(names.without_folders(value),
            (nlohmann::json{{"mass", 3}, {"warnings", {"ct.nii.gz: odd", "kg/m3"}}}));

  const InputNames kept(true, {scan});
  EXPECT_EQ(kept.name_of(scan), scan);
  EXPECT_EQ(kept.without_folders(scan + ": odd"), scan + ": odd");
}

TEST(InputNames, KeepsWordsThatAreNoPaths) {
  const TestFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::create_directories(folder / "scan/m");
  std::filesystem::current_path(folder.path());
  const InputNames names(false, {"scan", "scan/m"});
  EXPECT_EQ(names.without_folders(std::string("the scan: 3 scans, kg/m3, rescan/2")),
            "the scan: 3 scans, kg/m3, rescan/2");
  EXPECT_EQ(names.without_folders(std::string("scan: no slices; scan/1.dcm, scan/m/2.dcm")),
            "DICOM folder: no slices; 1.dcm, 2.dcm");
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace borelli
