#include "segmentation/files/terminology.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "segmentation/files/class_mapping.hpp"

namespace borelli {

namespace data {
extern const char* const terminology;
extern const char* const part_terms;
}  // namespace data

namespace {

std::vector<std::string> split_at(std::string_view text, char by) {
  std::vector<std::string> words(1);
  for (const char c : text)
    if (c == by)
      words.emplace_back();
    else
      words.back() += c;
  return words;
}

// The cells of a table's rows, without comments and the header.
std::vector<std::vector<std::string>> rows_of_terms(const char* table) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream text(table);
  for (std::string line; std::getline(text, line);)
    if (!line.empty() && !line.starts_with('#') && !line.starts_with("name\t"))
      rows.push_back(split_at(line, '\t'));
  return rows;
}

// "left", "right" or empty. Falls back to the meaning, because SNOMED CT, SRT and FMA use different codes.
std::string side_of(const CodedTerm& term) {
  if (term.value == "7771000" || term.value == "G-A101") return "left";
  if (term.value == "24028007" || term.value == "G-A100") return "right";
  const std::string meaning = plain_name(term.meaning);
  return meaning == "left" || meaning == "right" ? meaning : "";
}

// classes by "<code or meaning>/<region's code>/<side>"
const std::map<std::string, std::string>& classes() {
  static const auto all = [] {
    std::map<std::string, std::string> out;
    for (const auto& cell : rows_of_terms(data::terminology))  // name, code, meaning, region, side
      for (const auto& what : {cell[1], plain_name(cell[2])})
        out.try_emplace(what + "/" + cell[3] + "/" + cell[4], cell[0]);
    return out;
  }();
  return all;
}

CodedTerm term_of_side(const std::string& side) {
  if (side == "left") return {"SCT", "7771000", "Left"};
  if (side == "right") return {"SCT", "24028007", "Right"};
  return {};
}

CodedTerm term_in(std::string_view text) {
  auto words = split_at(text, '^');
  words.resize(3);
  return {words[0], words[1], words[2]};
}

}  // namespace

std::string class_of_terms(const SegmentTerms& terms) {
  const std::string own = side_of(terms.modifier), of_region = side_of(terms.region_modifier),
                    side = own.empty() ? of_region : own;
  std::vector<std::string> whats;
  if (terms.type.scheme == "SCT" || terms.type.scheme == "SRT") whats.push_back(terms.type.value);
  whats.push_back(plain_name(terms.type.meaning));
  // the region says where the type lies (a cyst of the kidney); most classes need none
  for (const std::string& region : {terms.region.value, std::string()})
    for (const std::string& what : whats) {
      if (what.empty()) continue;
      const auto it = classes().find(what + "/" + region + "/" + side);
      if (it != classes().end()) return it->second;
    }
  return "";
}

SegmentTerms terms_of_class(std::string_view name) {
  for (const auto& cell : rows_of_terms(data::part_terms))
    if (cell[0] == name) return {{"SCT", cell[1], cell[2]}, term_of_side(cell[3]), {}, {}};
  const auto rows = rows_of_terms(data::terminology);
  for (const auto& cell : rows) {
    if (cell[0] != name) continue;
    const auto region = std::ranges::find_if(rows, [&](const auto& r) { return r[1] == cell[3]; });
    if (region == rows.end()) return {{"SCT", cell[1], cell[2]}, term_of_side(cell[4]), {}, {}};
    return {{"SCT", cell[1], cell[2]}, {}, {"SCT", (*region)[1], (*region)[2]}, term_of_side(cell[4])};
  }
  return {{"SCT", "85756007", "Tissue"}, {}, {}, {}};
}

SegmentTerms terms_in_tags(std::string_view tags) {
  constexpr std::string_view key = "TerminologyEntry:";
  const auto at = tags.find(key);
  if (at == std::string_view::npos) return {};
  auto text = tags.substr(at + key.size());
  text = text.substr(0, text.find('|'));
  // context, category, type, its modifier, anatomic context, region, its modifier
  auto cells = split_at(text, '~');
  cells.resize(7);
  return {term_in(cells[2]), term_in(cells[3]), term_in(cells[5]), term_in(cells[6])};
}

std::vector<std::string> other_forms(std::string_view name) {
  const std::string plain = plain_name(name);
  for (const std::string side : {"left", "right"})
    if (plain.starts_with(side + "_")) return {plain.substr(side.size() + 1) + "_" + side};
  return {};
}

}  // namespace borelli
