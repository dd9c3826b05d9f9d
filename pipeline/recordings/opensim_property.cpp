#include "pipeline/recordings/opensim_property.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "error/printable.hpp"
#include "pipeline/recordings/text_rows.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

// The number of a word; NaN if it is none.
double number_or_infinity(std::string_view word) {
  std::string bare = lower_case(word);
  const bool minus = bare.starts_with('-');
  if (minus || bare.starts_with('+')) bare.erase(0, 1);
  if (bare == "inf" || bare == "infinity" || bare.starts_with("1.#inf"))
    return minus ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  return finite_number(word).value_or(std::numeric_limits<double>::quiet_NaN());
}

bool says_something(const XmlElement& element) {
  return !element.content.empty() ||
         std::any_of(element.children.begin(), element.children.end(), says_something);
}

// An element that says nothing needs no reader.
void mark_empty_as_read(const XmlElement& element) {
  if (!element.read && !says_something(element)) mark_read(element);
  for (const XmlElement& child : element.children) mark_empty_as_read(child);
}

bool changes_the_result(const XmlElement& element, const XmlElement&) {
  static const std::set<std::string, std::less<>> remarks{"credits", "publications", "length_units",
                                                          "force_units"};
  return !remarks.contains(element.name);
}

bool attribute_changes_the_result(const XmlAttribute& attribute, const XmlElement&) {
  return attribute.name == "file";  // an object that stands in another file
}

}  // namespace

const XmlElement& opensim_object(const XmlElement& root, const std::vector<std::string_view>& names) {
  const auto is_it = [&](const XmlElement& element) {
    return std::ranges::find(names, element.name) != names.end();
  };
  root.read = true;
  if (is_it(root)) return root;
  if (root.name != "OpenSimDocument")
    root.refuse(
        fmt::format("is not a <{}>; expected that, or an <OpenSimDocument> that contains it", names[0]));
  root.find("Version");
  const XmlElement* found = nullptr;
  for (const XmlElement& child : root.children) {
    if (!is_it(child)) continue;
    if (found) child.refuse("is the second one in the file; expected one");
    found = &child;
  }
  if (!found)
    root.refuse(fmt::format("holds {}, expected a <{}>",
                            root.children.empty() ? "nothing" : "<" + printable(root.children[0].name) + ">",
                            names[0]));
  found->read = true;
  return *found;
}

std::vector<const XmlElement*> set_objects(const XmlElement* set) {
  std::vector<const XmlElement*> out;
  if (!set) return out;
  set->read = true;
  set->find("name");
  const XmlElement* objects = set->child("objects");
  for (const XmlElement& element : (objects ? objects : set)->children)
    if (element.name != "groups" && element.name != "defaults") out.push_back(&element);
  return out;
}

std::string property_text(const XmlElement& owner, std::string_view name, std::string_view standard) {
  const XmlElement* found = owner.child(name);
  if (!found) return std::string(standard);
  if (!found->children.empty())
    found->refuse(fmt::format("holds <{}>, expected text", printable(found->children[0].name)));
  return found->content == "Unassigned" ? "" : found->content;
}

bool property_flag(const XmlElement& owner, std::string_view name, bool standard) {
  const std::string word = lower_case(property_text(owner, name, standard ? "true" : "false"));
  if (word == "true" || word == "1") return true;
  if (word == "false" || word == "0") return false;
  owner.child(name)->refuse(fmt::format("is '{}', expected true or false", printable(word)));
}

double property_number(const XmlElement& owner, std::string_view name, double standard) {
  const std::string word = property_text(owner, name);
  if (word.empty()) return standard;
  const double value = number_or_infinity(word);
  if (std::isnan(value))
    owner.child(name)->refuse(fmt::format("is '{}', expected a number", printable(word)));
  return value;
}

std::pair<double, double> property_range(const XmlElement& owner, std::string_view name) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::string text = property_text(owner, name);
  if (text.empty()) return {-infinity, infinity};
  std::vector<double> ends;
  for (const std::string& word : property_words(owner, name)) ends.push_back(number_or_infinity(word));
  if (ends.size() != 2 || !(ends[0] <= ends[1]))
    owner.child(name)->refuse(fmt::format("is '{}', expected its start and its end", printable(text)));
  return {ends[0], ends[1]};
}

std::vector<std::string> property_words(const XmlElement& owner, std::string_view name) {
  std::string text = property_text(owner, name);
  std::ranges::replace(text, '\n', ' ');
  std::vector<std::string> words;
  for (const std::string_view word : blank_words(text)) words.emplace_back(word);
  return words;
}

std::filesystem::path property_path(const XmlElement& owner, std::string_view name) {
  std::string text = property_text(owner, name);
  if (text.empty()) return {};
  std::ranges::replace(text, '\\', '/');
  return (std::filesystem::path(owner.file).parent_path() / text).lexically_normal();
}

std::string component_name(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == path.npos ? path : path.substr(slash + 1);
}

NotModelled not_read(const XmlElement& root) {
  NotModelled out;
  mark_empty_as_read(root);
  list_unread(root, {changes_the_result, attribute_changes_the_result}, out);
  return out;
}

}  // namespace borelli
