#include "dynamics/formats/mjcf_defaults.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "dynamics/formats/unread.hpp"

namespace borelli {
namespace {

using Attributes = std::vector<XmlAttribute>;
using Class = std::map<std::string, Attributes>;  // by the kind of element

bool is_orientation(const std::string& name) {
  return name == "quat" || name == "axisangle" || name == "euler" || name == "xyaxes" || name == "zaxis";
}

// A size may be given in part; the class supplies the remaining numbers.
void complete(XmlAttribute& own, const XmlAttribute& other) {
  if (own.name != "size") return;
  std::istringstream given(own.value), standard(other.value);
  for (std::string mine, word; standard >> word;)
    if (!(given >> mine)) own.value += " " + word;
}

// `own` with the attributes of `others` that it lacks.
Attributes merged(const Attributes& own, const Attributes& others) {
  Attributes out = own;
  const bool turned =
      std::any_of(own.begin(), own.end(), [](const auto& a) { return is_orientation(a.name); });
  for (const XmlAttribute& a : others) {
    const auto said = std::find_if(out.begin(), out.end(), [&](const auto& o) { return o.name == a.name; });
    if (said != out.end()) complete(*said, a);
    if (said != out.end() || (turned && is_orientation(a.name))) continue;
    out.push_back(a);
    out.back().own = false;
    out.back().read = false;
  }
  return out;
}

class Defaults {
 public:
  explicit Defaults(const XmlElement& root) {
    for (const XmlElement& section : root.children)
      if (section.name == "default") {
        const std::string name = section.text("class", "main");
        if (outermost_.empty()) outermost_ = name;
        add(section, name, outermost_);
        mark_read(section);
      }
    classes_.try_emplace(outermost_);
  }

  /// `around`: the childclass in effect here.
  void apply(XmlElement& parent, std::string around) {
    if (const std::string* own = parent.find("childclass")) around = checked(parent, "childclass", *own);
    for (XmlElement& c : parent.children) {
      const bool in_equality = parent.name == "equality";
      const bool in_tendon = parent.name == "tendon";
      if (in_equality || in_tendon || c.name == "joint" || c.name == "geom" || c.name == "mesh" ||
          c.name == "pair" || c.name == "site") {
        const std::string* own = c.find("class");
        const Class& chosen = classes_.at(own ? checked(c, "class", *own) : around);
        const auto found = chosen.find(in_equality ? "equality" : in_tendon ? "tendon" : c.name);
        if (found != chosen.end()) c.attributes = merged(c.attributes, found->second);
      } else if (c.name == "body" || c.name == "frame" || c.name == "replicate") {
        apply(c, around);
      }
    }
  }

  const std::string& outermost() const { return outermost_; }

 private:
  void add(const XmlElement& section, const std::string& name, const std::string& parent) {
    const auto above = classes_.find(parent);
    Class& own = classes_.try_emplace(name, above == classes_.end() ? Class{} : above->second).first->second;
    for (const XmlElement& c : section.children)
      if (c.name != "default") own[c.name] = merged(c.attributes, own[c.name]);
    for (const XmlElement& c : section.children)
      if (c.name == "default") add(c, c.require("class"), name);
  }

  const std::string& checked(const XmlElement& element, const char* key, const std::string& name) const {
    if (!classes_.contains(name))
      element.refuse(key, fmt::format("there is no class of defaults named '{}'", name));
    return name;
  }

  std::string outermost_;
  std::map<std::string, Class> classes_;
};

}  // namespace

void apply_mjcf_defaults(XmlElement& root) {
  Defaults defaults(root);
  for (XmlElement& section : root.children)
    if (section.name == "worldbody" || section.name == "asset" || section.name == "equality" ||
        section.name == "contact" || section.name == "tendon")
      defaults.apply(section, defaults.outermost());
}

}  // namespace borelli
