// Properties in OpenSim's XML files: text, paths and sets as OpenSim's versions write them.
#include "pipeline/recordings/opensim_property.hpp"

#include <gtest/gtest.h>

#include "tests/pipeline/program_run.hpp"

namespace borelli::test::opensim_property_test {
namespace {

XmlElement xml_of(const TestFolder& folder, const std::string& text) {
  return read_xml(folder.write("a.xml", text));
}

TEST(OpenSimProperty, TextIsWholeAroundCommentsAndEntities) {
  const TestFolder folder;
  const XmlElement root = xml_of(folder,
                                 "<a>\n <b> one<!-- no --> &amp;\n two </b><c><![CDATA[ <x> ]]></c><d/>"
                                 "<e>Unassigned</e>between</a>");
  EXPECT_EQ(property_text(root, "b"), "one &\n two");
  EXPECT_EQ(property_text(root, "c"), "<x>");
  EXPECT_EQ(property_text(root, "d", "standard"), "");
  EXPECT_EQ(property_text(root, "e"), "");
  EXPECT_EQ(property_text(root, "f", "standard"), "standard");
  EXPECT_EQ(root.content, "");  // text between elements is dropped
}

TEST(OpenSimProperty, PathsBelongToTheFilesFolder) {
  const TestFolder folder;
  const XmlElement root = xml_of(folder, "<a><b> ../x/y.mot </b><c>/abs/z.mot</c><d>sub\\w.mot</d><e/></a>");
  EXPECT_EQ(property_path(root, "b"), folder.path().parent_path() / "x" / "y.mot");
  EXPECT_EQ(property_path(root, "c"), "/abs/z.mot");
  EXPECT_EQ(property_path(root, "d"), folder.path() / "sub" / "w.mot");
  EXPECT_TRUE(property_path(root, "e").empty());
  EXPECT_EQ(component_name("/bodyset/calcn_r"), "calcn_r");
  EXPECT_EQ(component_name("calcn_r"), "calcn_r");
}

TEST(OpenSimProperty, SetsHoldTheirObjectsWithOrWithoutALevelBetween) {
  const TestFolder folder;
  const XmlElement root =
      xml_of(folder, "<a><s><objects><x/><y/></objects><groups/></s><t><x/><groups/></t></a>");
  EXPECT_EQ(set_objects(root.child("s")).size(), 2U);
  EXPECT_EQ(set_objects(root.child("t")).size(), 1U);
  EXPECT_TRUE(set_objects(nullptr).empty());
}

}  // namespace
}  // namespace borelli::test::opensim_property_test
