#include "dynamics/formats/xml_element.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include "error/xml_watch.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"

namespace borelli {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// Builds the tree from expat's events.
struct TreeBuilder : XmlWatch {
  TreeBuilder(std::string of, XML_Parser parser, std::string_view text)
      : XmlWatch(parser, text), file(std::move(of)) {}

  std::string file;
  XmlElement root;
  std::vector<XmlElement*> open{};  // from the root to the element being read

  static TreeBuilder& of(void* self) { return static_cast<TreeBuilder&>(*static_cast<XmlWatch*>(self)); }
  static void start(void* self, const XML_Char* name, const XML_Char** attributes) {
    of(self).begin(name, attributes);
  }
  static void end(void* self, const XML_Char*) { of(self).finish(); }
  static void text(void* self, const XML_Char* from, int count) {
    auto& open = of(self).open;
    if (open.back()->children.empty()) open.back()->content.append(from, std::size_t(count));
  }

  void begin(const char* name, const char** attributes) {
    if (std::ssize(open) >= deepest_xml)
      refuse(fmt::format("elements are nested deeper than {}", deepest_xml));
    check_attributes();
    if (!open.empty()) open.back()->content = {};
    XmlElement* element = open.empty() ? &root : &open.back()->children.emplace_back();
    element->name = name;
    element->file = file;
    element->line = static_cast<int>(XML_GetCurrentLineNumber(parser()));
    for (; *attributes; attributes += 2)
      element->attributes.push_back(
          {.name = attributes[0], .value = attributes[1], .where = element->where()});
    open.push_back(element);
  }

  void finish() {
    std::string& content = open.back()->content;
    const auto blank = [](char c) { return is_space(c); };
    content.erase(std::find_if_not(content.rbegin(), content.rend(), blank).base(), content.end());
    content.erase(content.begin(), std::find_if_not(content.begin(), content.end(), blank));
    open.pop_back();
  }
};

// Finite numbers separated by white space; `refuse` gets a sentence that follows the text's name.
template <class Refuse>
std::vector<double> numbers_in(const std::string& text, std::size_t least, std::size_t most,
                               const Refuse& refuse) {
  std::vector<double> out;
  const char *at = text.data(), *end = at + text.size();
  for (;;) {
    while (at != end && is_space(*at)) ++at;
    if (at == end) break;
    const char* word_end = std::find_if(at, end, is_space);
    const char* begin = *at == '+' ? at + 1 : at;  // (from_chars rejects a plus sign)
    double x = 0;
    const auto [stop, problem] = std::from_chars(begin, word_end, x);
    if (problem != std::errc{} || stop != word_end || !std::isfinite(x))
      refuse(fmt::format("contains '{}', expected finite numbers", std::string(at, word_end)));
    out.push_back(x);
    at = word_end;
  }
  if (out.size() < least || out.size() > most)
    refuse(fmt::format("contains {} numbers, expected {}{}", out.size(),
                       least == most ? "" : fmt::format("{} to ", least), most));
  return out;
}

}  // namespace

const std::string* XmlElement::find(std::string_view key) const {
  for (const XmlAttribute& a : attributes)
    if (a.name == key) {
      a.read = true;
      return &a.value;
    }
  return nullptr;
}

const std::string& XmlElement::require(std::string_view key) const {
  if (const std::string* value = find(key)) return *value;
  refuse(fmt::format("{} is missing", key));
}

std::string XmlElement::text(std::string_view key, std::string_view standard) const {
  const std::string* value = find(key);
  return value ? *value : std::string(standard);
}

std::vector<double> XmlElement::numbers(std::string_view key, std::size_t least, std::size_t most) const {
  const std::string* value = find(key);
  if (!value) return {};
  return numbers_in(*value, least, most,
                    [&](const std::string& problem) { refuse(key, fmt::format("{} {}", key, problem)); });
}

std::vector<double> XmlElement::content_numbers(std::size_t least, std::size_t most) const {
  read = true;
  return numbers_in(content, least, most, [&](const std::string& problem) { refuse(problem); });
}

double XmlElement::number(std::string_view key, double standard) const {
  const auto given = numbers(key, 1, 1);
  return given.empty() ? standard : given[0];
}

double XmlElement::not_negative(std::string_view key, double standard) const {
  const double value = number(key, standard);
  if (value < 0) refuse(key, fmt::format("{} is {:g}, expected 0 or more", key, value));
  return value;
}

Eigen::Vector3d XmlElement::vector(std::string_view key, const Eigen::Vector3d& standard) const {
  const auto given = numbers(key, 3, 3);
  return given.empty() ? standard : Eigen::Vector3d(given[0], given[1], given[2]);
}

std::string XmlElement::word(std::string_view key, const std::vector<std::string_view>& words,
                             std::string_view standard) const {
  const std::string* value = find(key);
  if (!value) return std::string(standard);
  if (std::find(words.begin(), words.end(), *value) == words.end())
    refuse(key, fmt::format("{} is '{}', expected one of: {}", key, *value, fmt::join(words, ", ")));
  return *value;
}

bool XmlElement::boolean(std::string_view key, bool standard) const {
  return word(key, {"true", "false"}, standard ? "true" : "false") == "true";
}

const XmlElement* XmlElement::child(std::string_view child_name) const {
  const XmlElement* found = nullptr;
  for (const XmlElement& c : children) {
    if (c.name != child_name) continue;
    if (found) c.refuse(fmt::format("{} has two of these; expected one", describe()));
    found = &c;
    c.read = true;
  }
  return found;
}

const XmlElement& XmlElement::require_child(std::string_view child_name) const {
  if (const XmlElement* found = child(child_name)) return *found;
  refuse(fmt::format("has no <{}>", child_name));
}

std::string XmlElement::where() const { return fmt::format("{}:{}", file, line); }

std::string XmlElement::describe() const {
  for (const XmlAttribute& a : attributes)
    if (a.name == "name" && !a.value.empty()) return fmt::format("{} '{}'", name, a.value);
  return name;
}

void XmlElement::refuse(const std::string& sentence) const {
  throw XmlRefusal{Error{where(), describe() + ": " + sentence, Error::Kind::use}};
}

void XmlElement::refuse(std::string_view key, const std::string& sentence) const {
  for (const XmlAttribute& a : attributes)
    if (a.name == key) throw XmlRefusal{Error{a.where, describe() + ": " + sentence, Error::Kind::use}};
  refuse(sentence);
}

void admit_xml(const std::string& where, std::size_t elements) {
  constexpr double element_size = 1000;  // bytes, with a few attributes and what is made from them
  constexpr std::size_t few = 10000;
  if (elements < few) return;
  const auto fits = admit_memory(where, fmt::format("a model of {} elements", elements),
                                 element_size * static_cast<double>(elements));
  if (!fits) throw XmlRefusal{fits.error()};
}

XmlElement read_xml(const std::filesystem::path& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) throw XmlRefusal{bytes.error()};
  const std::string& text = *bytes;
  // an element has a tag; attributes beyond a few count as further elements
  admit_xml(path.string(), static_cast<std::size_t>(std::max(std::count(text.begin(), text.end(), '<'),
                                                             std::count(text.begin(), text.end(), '=') / 3)));

  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                            &XML_ParserFree);
  TreeBuilder builder(path.string(), parser.get(), text);
  XML_SetElementHandler(parser.get(), &TreeBuilder::start, &TreeBuilder::end);
  XML_SetCharacterDataHandler(parser.get(), &TreeBuilder::text);
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE) == XML_STATUS_ERROR)
    throw XmlRefusal{Error{fmt::format("{}:{}", path.string(), XML_GetCurrentLineNumber(parser.get())),
                           builder.why_stopped(), Error::Kind::use}};
  return std::move(builder.root);
}

XmlElement read_xml_named(const XmlElement& by, const std::filesystem::path& file) {
  if (const auto fine = check_input_file(file); !fine)
    by.refuse("file", fmt::format("{}: {}", fine.error().what, file.string()));
  return read_xml(file);
}

}  // namespace borelli
