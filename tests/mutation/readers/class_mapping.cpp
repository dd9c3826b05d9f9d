// Tables from foreign classes to parts, as text and as JSON.
#include "segmentation/files/class_mapping.hpp"

#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_class_mapping {

std::vector<TestCase> seeds() {
  return {
      {"tabs",
       {{"a.tsv",
         "# by hand\nlabel\tname\tpart\ttissue\n1\tspleen\ttrunk\tsoft\n75\tfemur_left\tthigh_left\tbone\n"
         "3\tskin\tbody\t\n4\ttable\toutside\tair\n5\tleg\tthigh_left,shank_left\tfat\n"}}},
      {"names", {{"a.tsv", "name\tpart\nhead\thead\nRight Arm\tarm_right\n"}}},
      {"json",
       {{"a.json",
         "{\"1\": \"thigh_left\", \"skin\": {\"part\": \"body\", \"tissue\": \"fat\"},\n"
         " \"4\": {\"part\": \"outside\"}}\n"}}}};
}

Result<void> read(const std::filesystem::path& file) {
  const auto mapping = class_mapping(file.string());
  if (!mapping) return tl::unexpected(mapping.error());
  for (const auto& entry : mapping->entries)
    if (!mapping->find(entry.label.value_or(0), entry.name)) return defect("an entry is not found");
  return {};
}

}  // namespace of_class_mapping

Reader class_mapping_reader() { return {"class_mapping", of_class_mapping::seeds, of_class_mapping::read}; }

}  // namespace borelli::mutation
