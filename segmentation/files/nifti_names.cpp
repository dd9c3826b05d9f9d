#include "segmentation/files/nifti_names.hpp"

#include <fmt/core.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "error/xml_watch.hpp"

namespace borelli {
namespace {

using Names = std::map<std::int64_t, std::string>;

struct Table : XmlWatch {
  using XmlWatch::XmlWatch;
  static Table& of(void* user) { return static_cast<Table&>(*static_cast<XmlWatch*>(user)); }

  Names names;
  std::optional<std::int64_t> key;  // of the open Label element
  std::string text;
};

void begin(void* user, const char* element, const char** attributes) {
  auto& table = Table::of(user);
  table.check_attributes();
  if (std::string_view(element) != "Label") return;
  table.text.clear();
  for (; *attributes; attributes += 2) {
    const std::string_view value(attributes[1]);
    std::int64_t key = 0;
    if (std::string_view(attributes[0]) == "Key" &&
        std::from_chars(value.data(), value.data() + value.size(), key).ec == std::errc{})
      table.key = key;
  }
}

void text(void* user, const char* bytes, int count) {
  auto& table = Table::of(user);
  if (table.key) table.text.append(bytes, static_cast<std::size_t>(count));
}

void end(void* user, const char* element) {
  auto& table = Table::of(user);
  if (std::string_view(element) != "Label") return;
  const auto first = table.text.find_first_not_of(" \t\r\n"), last = table.text.find_last_not_of(" \t\r\n");
  if (table.key.value_or(0) > 0 && first != std::string::npos)
    table.names.emplace(*table.key, table.text.substr(first, last - first + 1));
  table.key.reset();
}

Result<Names> names_in(const std::string& path, std::string_view xml) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                            &XML_ParserFree);
  Table table(parser.get(), xml);
  XML_SetElementHandler(parser.get(), begin, end);
  XML_SetCharacterDataHandler(parser.get(), text);
  if (XML_Parse(parser.get(), xml.data(), static_cast<int>(xml.size()), 1) != XML_STATUS_OK)
    return failure(
        path, fmt::format("has label names in its header in a text that {}; write the file again without "
                          "these names",
                          table.why_stopped()));
  return std::move(table.names);
}

// The content of the first extension with a label table; empty if there is none.
std::string_view label_table(std::string_view extensions, bool swap) {
  constexpr std::size_t head = 8;  // size and code
  if (extensions.size() < 4 || extensions[0] == 0) return {};
  for (std::size_t at = 4; at + head <= extensions.size();) {
    std::uint32_t size;
    std::memcpy(&size, extensions.data() + at, sizeof size);
    if (swap) size = __builtin_bswap32(size);
    if (size < head || size > extensions.size() - at) break;
    const std::string_view content = extensions.substr(at + head, size - head);
    if (content.find("<LabelTable") != std::string_view::npos) return content.substr(0, content.find('\0'));
    at += size;
  }
  return {};
}

}  // namespace

Result<std::vector<ImageSegment>> nifti_label_names(const ImageHeader& header, std::uint64_t header_bytes) {
  std::vector<ImageSegment> named;
  constexpr std::uint64_t most = 1 << 24;
  if (header.stream_offset <= header_bytes + 4 || header.stream_offset - header_bytes > most) return named;
  auto source = ByteSource::open(header.data_file, header.packing);
  if (!source) return tl::unexpected(source.error());
  if (auto skipped = source->skip(header_bytes); !skipped) return tl::unexpected(skipped.error());
  std::string bytes(header.stream_offset - header_bytes, '\0');
  const auto got = source->read(std::as_writable_bytes(std::span(bytes)));
  if (!got) return tl::unexpected(got.error());
  bytes.resize(*got);
  const bool swap = header.big_endian != (std::endian::native == std::endian::big);
  const std::string_view xml = label_table(bytes, swap);
  if (xml.empty()) return named;
  const auto names = names_in(header.data_file, xml);
  if (!names) return tl::unexpected(names.error());
  for (const auto& [number, name] : *names) named.push_back({name, number, 0});
  return named;
}

}  // namespace borelli
