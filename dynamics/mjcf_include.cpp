#include "dynamics/mjcf_include.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace borelli {
namespace {

using std::filesystem::path;

void expand(XmlElement& element, const path& folder, std::vector<path>& open) {
  std::vector<XmlElement> children;
  for (XmlElement& c : element.children) {
    if (c.name != "include") {
      expand(c, folder, open);
      children.push_back(std::move(c));
      continue;
    }
    const path file = (folder / c.require("file")).lexically_normal();
    std::error_code problem;
    if (!std::filesystem::is_regular_file(file, problem))
      c.refuse("file", fmt::format("no such file: {}", file.string()));
    const path canonical = std::filesystem::weakly_canonical(file);
    if (std::find(open.begin(), open.end(), canonical) != open.end())
      c.refuse("file", fmt::format("{} includes itself", file.string()));
    XmlElement included = read_xml(file);
    open.push_back(canonical);
    expand(included, folder, open);
    open.pop_back();
    std::move(included.children.begin(), included.children.end(), std::back_inserter(children));
  }
  element.children = std::move(children);
}

}  // namespace

void put_in_includes(XmlElement& root) {
  const path main = root.file;
  std::vector<path> open{std::filesystem::weakly_canonical(main)};
  expand(root, main.parent_path(), open);
}

}  // namespace borelli
