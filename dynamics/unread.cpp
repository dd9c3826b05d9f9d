#include "dynamics/unread.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

namespace borelli {
namespace {

struct Kind {
  std::string first;                   // where
  int count = 0;                       // elements
  std::set<std::string> attributes;    // empty: the whole element is unread
  std::map<std::string, int> content;  // of an unread element: the names in it
};

struct Listing {
  std::vector<std::pair<std::string, Kind>> kinds;  // in the order of the file

  Kind& kind(const std::string& name) {
    const auto found =
        std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.first == name; });
    return found != kinds.end() ? found->second : kinds.emplace_back(name, Kind{}).second;
  }

  void add(const XmlElement& element) {
    for (const XmlElement& c : element.children)
      if (!c.read) {
        Kind& k = kind(fmt::format("<{}> in <{}>", c.name, element.name));
        if (k.count++ == 0) k.first = c.where();
        for (const XmlElement& inner : c.children) ++k.content[inner.name];
      } else {
        add_attributes(c, element);
        add(c);
      }
  }

  void add_attributes(const XmlElement& element, const XmlElement& parent) {
    Kind* k = nullptr;
    for (const XmlAttribute& a : element.attributes) {
      if (a.read) continue;
      if (!k) k = &kind(fmt::format("attributes of <{}> in <{}>", element.name, parent.name));
      if (k->first.empty()) k->first = a.where;
      k->attributes.insert(a.name);
    }
    if (k) ++k->count;
  }
};

std::string line(const std::string& name, const Kind& k) {
  std::string what;
  if (!k.attributes.empty()) {
    what = fmt::format(" ({})", fmt::join(k.attributes, ", "));
  } else if (!k.content.empty()) {
    std::vector<std::string> parts;
    for (const auto& [inner, count] : k.content) parts.push_back(fmt::format("{} <{}>", count, inner));
    what = fmt::format(" with {}", fmt::join(parts, ", "));
  }
  return fmt::format("{}{}: {}", name, what,
                     k.count == 1 ? "at " + k.first : fmt::format("{} times, first at {}", k.count, k.first));
}

}  // namespace

std::vector<std::string> list_unread(const XmlElement& root) {
  Listing listing;
  listing.add(root);
  std::vector<std::string> out;
  for (const auto& [name, kind] : listing.kinds) out.push_back(line(name, kind));
  return out;
}

void mark_read(const XmlElement& element) {
  element.read = true;
  for (const XmlAttribute& a : element.attributes) a.read = true;
  for (const XmlElement& c : element.children) mark_read(c);
}

}  // namespace borelli
