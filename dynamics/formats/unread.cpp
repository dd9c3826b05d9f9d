#include "dynamics/formats/unread.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

namespace borelli {
namespace {

struct Kind {
  std::string first;                   // first place
  int count = 0;                       // elements
  std::set<std::string> attributes;    // empty: the whole element is unread
  std::map<std::string, int> content;  // of an unread element: the names in it, with counts
};

// Kinds by name, in the order of the file.
class Kinds {
 public:
  Kind& operator[](const std::string& name) {
    const auto [at, is_new] = index_.try_emplace(name, kinds_.size());
    if (is_new) kinds_.emplace_back(name, Kind{});
    return kinds_[at->second].second;
  }
  auto begin() const { return kinds_.begin(); }
  auto end() const { return kinds_.end(); }

 private:
  std::vector<std::pair<std::string, Kind>> kinds_;
  std::map<std::string, std::size_t> index_;
};

std::string often(const Kind& k) {
  return k.count == 1 ? "at " + k.first : fmt::format("{} times, first at {}", k.count, k.first);
}

class Listing {
 public:
  explicit Listing(const MotionRules& rules) : rules_(rules) {}

  void add(const XmlElement& element) {
    for (const XmlElement& c : element.children)
      if (!c.read) {
        add_whole(c, element);
      } else {
        add_attributes(c, element);
        add(c);
      }
  }

  void put_into(NotModelled& out) const {
    for (const auto& [name, k] : motion_) out.motion.push_back(fmt::format("{}: {}", name, often(k)));
    for (const auto& [name, k] : other_) {
      std::string what;
      if (!k.attributes.empty()) {
        what = fmt::format(" ({})", fmt::join(k.attributes, ", "));
      } else if (!k.content.empty()) {
        std::vector<std::string> parts;
        for (const auto& [inner, count] : k.content) parts.push_back(fmt::format("{} <{}>", count, inner));
        what = fmt::format(" with {}", fmt::join(parts, ", "));
      }
      out.other.push_back(fmt::format("{}{}: {}", name, what, often(k)));
    }
  }

 private:
  static Kind& note(Kind& kind, const std::string& where) {
    if (kind.count++ == 0) kind.first = where;
    return kind;
  }

  // Lists an unread element under `motion_` if it, or a child, changes the motion; the rest under `other_`.
  void add_whole(const XmlElement& e, const XmlElement& parent) {
    const std::string name = fmt::format("<{}> in <{}>", e.name, parent.name);
    if (rules_.element(e, parent)) {
      note(motion_[name], e.where());
      return;
    }
    const bool child_moves = std::any_of(e.children.begin(), e.children.end(),
                                         [&](const XmlElement& c) { return rules_.element(c, e); });
    std::map<std::string, int> content;
    for (const XmlElement& c : e.children)
      if (rules_.element(c, e))
        note(motion_[fmt::format("<{}> in <{}>", c.name, e.name)], c.where());
      else
        ++content[c.name];
    if (child_moves && content.empty()) return;
    Kind& k = note(other_[name], e.where());
    for (const auto& [inner, times] : content) k.content[inner] += times;
  }

  void add_attributes(const XmlElement& element, const XmlElement& parent) {
    Kind* k = nullptr;
    for (const XmlAttribute& a : element.attributes) {
      if (a.read) continue;
      if (rules_.attribute(a, element)) {
        note(motion_[fmt::format("{} of <{}>", a.name, element.name)], a.where);
        continue;
      }
      if (!k)
        k = &note(other_[fmt::format("attributes of <{}> in <{}>", element.name, parent.name)], a.where);
      k->attributes.insert(a.name);
    }
  }

  const MotionRules& rules_;
  Kinds motion_, other_;
};

}  // namespace

void list_unread(const XmlElement& root, const MotionRules& rules, NotModelled& out) {
  Listing listing(rules);
  listing.add(root);
  listing.put_into(out);
}

void mark_read(const XmlElement& element) {
  element.read = true;
  for (const XmlAttribute& a : element.attributes) a.read = true;
  for (const XmlElement& c : element.children) mark_read(c);
}

}  // namespace borelli
