#include "segmentation/files/class_mapping.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <sstream>

#include "error/json_text.hpp"
#include "error/plain_cell.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {

namespace data {
extern const char* const totalsegmentator;
extern const char* const totalsegmentator_v1;
extern const char* const totalsegmentator_mr;
extern const char* const icrp110;
}  // namespace data

namespace {

// the parts that a word of the part column means; empty if it is not a part
std::optional<PartSet> parts_of_word(const std::string& word) {
  if (word == "outside") return PartSet{0};
  if (word == "body") return all_parts;
  if (const int label = part_label(word)) return part_bit(label);
  PartSet set = 0;
  const auto add = [&](std::string_view stem, std::string_view side) {
    for (const std::string_view at : {"_left", "_right"})
      if (side.empty() || side == at) set |= part_bit(part_label(std::string(stem) + std::string(at)));
  };
  if (word == "trunk" || word == "axial") {
    for (const char* name : {"upper_trunk", "middle_trunk", "lower_trunk"}) set |= part_bit(part_label(name));
    if (word == "axial") set |= part_bit(part_label("head"));
    return set;
  }
  std::string_view stem = word, side;
  for (const std::string_view at : {"_left", "_right"})
    if (stem.ends_with(at)) stem.remove_suffix(at.size()), side = at;
  if (stem == "arm") {
    for (const char* name : {"upper_arm", "forearm", "hand"}) add(name, side);
  } else if (stem == "leg") {
    for (const char* name : {"thigh", "shank", "foot"}) add(name, side);
  } else if (part_label(std::string(stem) + "_left")) {
    add(stem, side);
  }
  return set ? std::optional(set) : std::nullopt;
}

Result<ClassRule> read_rule(const std::string& where, std::string_view part, std::string_view tissue) {
  ClassRule rule{0, ClassTissue::any};
  std::size_t words = 0;
  for (std::size_t at = 0; at <= part.size();) {
    const auto end = std::min(part.find(',', at), part.size());
    const std::string word = plain_name(part.substr(at, end - at));
    const auto set = parts_of_word(word);
    if (!set)
      return failure(where,
                     fmt::format("'{}' is not a part; expected a part (thigh_left), several separated by "
                                 "commas, a group (thigh, arm_left, leg, trunk, axial, body) or outside",
                                 trimmed(part.substr(at, end - at))));
    rule.parts |= *set;
    ++words;
    if (*set == 0 && (words > 1 || end < part.size()))
      return failure(where, "a class that is outside the body cannot also belong to a part");
    at = end + 1;
  }
  constexpr std::string_view names[] = {"soft", "bone", "fat", "lung", "air"};
  if (tissue.empty()) return rule;
  const std::string word = plain_name(tissue);
  const auto found = std::ranges::find(names, word);
  if (found == std::end(names))
    return failure(where, fmt::format("'{}' is not a tissue; expected soft, bone, fat, lung or air", tissue));
  rule.tissue = static_cast<ClassTissue>(found - std::begin(names));
  return rule;
}

std::optional<std::int64_t> read_number(std::string_view text) {
  if (text.empty() || text.size() > 9 || text.find_first_not_of("0123456789") != std::string_view::npos)
    return std::nullopt;
  return std::stoll(std::string(text));
}

// Adds a class. Errors: a repeated label or name; label 0, which means no label, with a part.
Result<void> add(ClassMapping& mapping, const std::string& where, ClassMapping::Entry entry,
                 std::set<std::string>& seen) {
  if (entry.label && *entry.label == 0 && entry.rule.parts != 0)
    return failure(where, "label 0 means no class, so it can only be outside");
  for (const std::string& key : {entry.label ? fmt::format("label {}", *entry.label) : "",
                                 entry.name.empty() ? "" : plain_name(entry.name)})
    if (!key.empty() && !seen.insert(key).second) return failure(where, key + " appears twice");
  mapping.entries.push_back(std::move(entry));
  return {};
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  for (auto& cell : cells) cell = text_of_cell(trimmed(cell));
  return cells;
}

Result<ClassMapping> from_table(const std::string& path, std::istream& text) {
  ClassMapping mapping;
  std::set<std::string> seen;
  std::string line;
  std::ptrdiff_t label_column = -1, name_column = -1, part_column = -1, tissue_column = -1;
  for (int row = 1; std::getline(text, line); ++row) {
    const std::string where = fmt::format("{}:{}", path, row);
    if (trimmed(line).empty() || line.starts_with('#')) continue;
    const auto cells = cells_of(line);
    const auto cell = [&](std::ptrdiff_t column) {
      return column < 0 || column >= std::ssize(cells) ? std::string()
                                                       : cells[static_cast<std::size_t>(column)];
    };
    if (part_column < 0) {
      for (std::ptrdiff_t c = 0; c < std::ssize(cells); ++c) {
        const std::string name = plain_name(cell(c));
        if (name == "label" || name == "index") label_column = c;
        if (name == "name") name_column = c;
        if (name == "part") part_column = c;
        if (name == "tissue") tissue_column = c;
      }
      if (part_column < 0 || (label_column < 0 && name_column < 0))
        return failure(where,
                       "expected the header 'label<TAB>part', 'name<TAB>part' or "
                       "'label<TAB>name<TAB>part<TAB>tissue'; found '" +
                           line + "'");
      continue;
    }
    ClassMapping::Entry entry{std::nullopt, cell(name_column), {}};
    if (const std::string digits = cell(label_column); !digits.empty()) {
      entry.label = read_number(digits);
      if (!entry.label)
        return failure(where, "expected a label, a whole number from 0; found '" + digits + "'");
    }
    if (!entry.label && entry.name.empty()) return failure(where, "the row has neither a label nor a name");
    auto rule = read_rule(where, cell(part_column), cell(tissue_column));
    if (!rule) return tl::unexpected(rule.error());
    entry.rule = *rule;
    if (auto added = add(mapping, where, std::move(entry), seen); !added)
      return tl::unexpected(added.error());
  }
  return mapping;
}

Result<ClassMapping> from_json(const std::string& path, std::istream& text) {
  using nlohmann::json;
  const auto parsed = parse_json(std::string{std::istreambuf_iterator<char>(text), {}}, path);
  if (!parsed) return tl::unexpected(parsed.error());
  const json& document = *parsed;
  if (!document.is_object())
    return failure(
        path,
        "is not a mapping; expected an object from label or name to part, {\"femur_left\": \"thigh_left\"}");
  ClassMapping mapping;
  std::set<std::string> seen;
  for (const auto& [key, value] : document.items()) {
    if (key.empty()) return failure(path, "contains a class with neither label nor name");
    const std::string where = path + ": " + key;
    std::string part, tissue;
    if (value.is_string()) {
      part = value;
    } else if (value.is_object() && value.contains("part") && value["part"].is_string()) {
      part = value["part"];
      if (value.contains("tissue") && value["tissue"].is_string()) tissue = value["tissue"];
    } else {
      return failure(where, "expected a part, or {\"part\": ..., \"tissue\": ...}");
    }
    auto rule = read_rule(where, part, tissue);
    if (!rule) return tl::unexpected(rule.error());
    ClassMapping::Entry entry{read_number(key), {}, *rule};
    if (!entry.label) entry.name = key;
    if (auto added = add(mapping, where, std::move(entry), seen); !added)
      return tl::unexpected(added.error());
  }
  return mapping;
}

}  // namespace

std::string plain_name(std::string_view name) {
  std::string out;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) || letter >= 0x80)
      out += static_cast<char>(std::tolower(letter));
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  if (out.ends_with('_')) out.pop_back();
  return out;
}

const ClassRule* ClassMapping::find(std::int64_t label, std::string_view name) const {
  if (!name.empty())
    for (const Entry& entry : entries)
      if (!entry.name.empty() && plain_name(entry.name) == plain_name(name)) return &entry.rule;
  for (const Entry& entry : entries)
    if (entry.label == label && (name.empty() || entry.name.empty())) return &entry.rule;
  return nullptr;
}

Result<ClassMapping> class_mapping(const std::string& name_or_file) {
  Result<ClassMapping> mapping;
  const char* const tables[] = {data::totalsegmentator, data::totalsegmentator_v1, data::totalsegmentator_mr,
                                data::icrp110};
  if (const auto* ready = std::ranges::find(ready_mappings, name_or_file);
      ready != std::end(ready_mappings)) {
    std::istringstream text(tables[ready - std::begin(ready_mappings)]);
    return from_table(name_or_file, text);
  }
  if (std::error_code ignored; !std::filesystem::exists(name_or_file, ignored)) {
    std::string ready;
    for (const auto name : ready_mappings) ready += (ready.empty() ? "" : ", ") + std::string(name);
    return bad_use(name_or_file, "unknown mapping; give a file, or one of " + ready);
  }
  const auto text = read_input_file(name_or_file);
  if (!text) return tl::unexpected(text.error());
  std::istringstream file(*text);
  mapping = lower_case(name_or_file).ends_with(".json") ? from_json(name_or_file, file)
                                                        : from_table(name_or_file, file);
  if (mapping && mapping->entries.empty()) return failure(name_or_file, "contains no class");
  return mapping;
}

}  // namespace borelli
