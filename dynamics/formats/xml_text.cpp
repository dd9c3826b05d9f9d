#include "dynamics/formats/xml_text.hpp"

#include <fmt/core.h>

namespace borelli {
namespace {

constexpr const char* comment_name = "!--";

// The number of bytes of the UTF-8 character at the start of `text`; 0: no character that XML can hold.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  unsigned code = first & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  const unsigned least = length == 3 ? 0x800 : length == 4 ? 0x10000 : 0;
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  return code < least || code > 0x10FFFF || surrogate || code == 0xFFFE || code == 0xFFFF ? 0 : length;
}

// White space of attributes is escaped too: readers turn it into blanks.
std::string escaped(std::string_view text, bool in_attribute) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    const char c = text[0];
    if (length == 0)
      out += '?';
    else if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '\r' || (in_attribute && (c == '"' || c == '\n' || c == '\t')))
      out += fmt::format("&#{};", int(c));
    else
      out += text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

// A comment cannot hold two hyphens in a row, nor end in one.
std::string comment_text(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    if (text[0] == '-' && !out.empty() && out.back() == '-') out += ' ';
    out += length == 0 ? std::string_view("?") : text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  if (!out.empty() && out.back() == '-') out += ' ';
  return out;
}

void write(const XmlNode& node, std::size_t depth, std::string& out) {
  out.append(2 * depth, ' ');
  if (node.name == comment_name) {
    out += fmt::format("<!-- {} -->\n", comment_text(node.content));
    return;
  }
  out += fmt::format("<{}", node.name);
  for (const auto& [key, value] : node.attributes)
    out += fmt::format(" {}=\"{}\"", key, escaped(value, true));
  if (node.children.empty() && node.content.empty()) {
    out += "/>\n";
    return;
  }
  if (node.children.empty()) {
    out += fmt::format(">{}</{}>\n", escaped(node.content, false), node.name);
    return;
  }
  out += ">\n";
  for (const XmlNode& child : node.children) write(child, depth + 1, out);
  out.append(2 * depth, ' ');
  out += fmt::format("</{}>\n", node.name);
}

}  // namespace

XmlNode& XmlNode::add(std::string child) {
  XmlNode& node = children.emplace_back();
  node.name = std::move(child);
  return node;
}

XmlNode& XmlNode::add(std::string child, std::string text) {
  XmlNode& node = add(std::move(child));
  node.content = std::move(text);
  return node;
}

void XmlNode::comment(std::string text) { add(comment_name, std::move(text)); }

XmlNode& XmlNode::set(std::string key, std::string text) {
  attributes.emplace_back(std::move(key), std::move(text));
  return *this;
}

XmlNode& XmlNode::set(std::string key, double number) { return set(std::move(key), exact_text(number)); }

XmlNode& XmlNode::set(std::string key, const std::vector<double>& numbers) {
  return set(std::move(key), exact_text(numbers));
}

XmlNode& XmlNode::set(std::string key, const Eigen::Vector3d& vector) {
  return set(std::move(key), std::vector{vector.x(), vector.y(), vector.z()});
}

std::string exact_text(double number) { return fmt::format("{}", number == 0 ? 0.0 : number); }

std::string exact_text(const std::vector<double>& numbers) {
  std::string out;
  for (const double x : numbers) out += (out.empty() ? "" : " ") + exact_text(x);
  return out;
}

std::string xml_text(const XmlNode& root) {
  std::string out = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";
  write(root, 0, out);
  return out;
}

}  // namespace borelli
