// The colour table beside a label map, read as 3D Slicer's documentation of the format says: comments, then a
// line of id, name without blanks, and four numbers from 0 to 255.
#include "pipeline/files/colour_table.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "pipeline/files/palette.hpp"

namespace borelli {
namespace {

TEST(ColourTable, HasALinePerLabelInThePalettesColours) {
  LabelMap labels;
  for (const Part& part : parts) labels.names.emplace_back(part.name);
  labels.names.resize(19);
  labels.names[17] = "left lung";
  std::istringstream text(colour_table(labels));
  std::string line;
  std::getline(text, line);
  EXPECT_TRUE(line.starts_with("# Color table file")) << line;
  std::size_t count = 0;
  while (std::getline(text, line)) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    std::size_t id = 0;
    std::string name, rest;
    int r = -1, g = -1, b = -1, a = -1;
    ASSERT_TRUE(fields >> id >> name >> r >> g >> b >> a) << line;
    EXPECT_FALSE(fields >> rest) << line;
    EXPECT_EQ(id, count++);
    for (const int c : {r, g, b, a}) EXPECT_TRUE(c >= 0 && c <= 255) << line;
    EXPECT_EQ(a, id == 0 ? 0 : 255);
    if (id > 0 && id < parts.size()) {
      EXPECT_EQ(name, parts[id].name);
      EXPECT_EQ(
          (Colour{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)}),
          part_colours[id]);
    }
    if (id == 17) {
      EXPECT_EQ(name, "left_lung");
    }
    if (id == 18) {
      EXPECT_EQ(name, "label_18");
    }
  }
  EXPECT_EQ(count, 19U);
  EXPECT_EQ(colour_file("out/labels.nii.gz"), "out/labels.ctbl");
}

}  // namespace
}  // namespace borelli
