#include "dynamics/formats/mjcf_include.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>

namespace borelli {
namespace {

using std::filesystem::path;

constexpr std::size_t include_costs = 20;  // in elements, so that many tiny includes are bounded too

class Includer {
 public:
  explicit Includer(const XmlElement& root) : folder_(path(root.file).parent_path()) {
    open_.push_back(std::filesystem::weakly_canonical(root.file));
  }

  void expand(XmlElement& element, int depth) {
    if (depth > deepest_xml) element.refuse(fmt::format("elements are nested deeper than {}", deepest_xml));
    if (std::none_of(element.children.begin(), element.children.end(),
                     [](const XmlElement& c) { return c.name == "include"; })) {
      for (XmlElement& c : element.children) expand(c, depth + 1);
      return;
    }
    std::vector<XmlElement> children;
    for (XmlElement& c : element.children) {
      if (c.name != "include") {
        expand(c, depth + 1);
        children.push_back(std::move(c));
        continue;
      }
      const File& file = load(c);
      if (std::find(open_.begin(), open_.end(), file.canonical) != open_.end())
        c.refuse("file", fmt::format("{} includes itself", file.root.file));
      XmlElement included = file.root;
      open_.push_back(file.canonical);
      expand(included, depth);
      open_.pop_back();
      std::move(included.children.begin(), included.children.end(), std::back_inserter(children));
    }
    element.children = std::move(children);
  }

 private:
  struct File {
    path canonical;
    XmlElement root;
    std::size_t size;
  };

  static std::size_t size_of(const XmlElement& e) {
    std::size_t out = 1;
    for (const XmlElement& c : e.children) out += size_of(c);
    return out;
  }

  const File& load(const XmlElement& include) {
    const std::string& name = include.require("file");
    auto known = files_.find(name);
    if (known == files_.end()) {
      const path file = (folder_ / name).lexically_normal();
      XmlElement root = read_xml_named(include, file);
      const std::size_t size = size_of(root);
      known =
          files_.emplace(name, File{std::filesystem::weakly_canonical(file), std::move(root), size}).first;
    }
    elements_ += include_costs + known->second.size;
    if (elements_ > most_mjcf_elements)
      include.refuse(
          fmt::format("the model grows to more than {} elements through its includes", most_mjcf_elements));
    return known->second;
  }

  const path folder_;
  std::vector<path> open_;             // the files being expanded, outermost first
  std::map<std::string, File> files_;  // by the name in <include>
  std::size_t elements_ = 0;           // included so far
};

}  // namespace

void put_in_includes(XmlElement& root) { Includer(root).expand(root, 1); }

}  // namespace borelli
