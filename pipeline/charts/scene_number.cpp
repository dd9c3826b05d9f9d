#include "pipeline/charts/scene_number.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "dynamics/formats/toml_text.hpp"
#include "error/nearest_name.hpp"

namespace borelli {
namespace {

// largest number of paths in an error
constexpr std::size_t most_suggested = 6;

constexpr std::string_view lists[] = {"solid", "effort", "constraint"};

/// The `name` of a table, or empty.
std::string name_in(const toml::node& node) {
  const toml::table* table = node.as_table();
  return table ? (*table)["name"].value_or(std::string()) : std::string();
}

bool is_number(const toml::node& node) { return node.is_integer() || node.is_floating_point(); }

double value_of(const toml::node& node) {
  return node.is_integer() ? double(node.as_integer()->get()) : node.as_floating_point()->get();
}

/// Splits "solid[bar 2].joint[0]" into solid, [bar 2], joint, [0; bracketed steps keep the opening bracket.
std::optional<std::vector<std::string>> steps_of(const std::string& path) {
  std::vector<std::string> out;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) out.push_back(std::exchange(word, {}));
  };
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] == '.') {
      end_word();
    } else if (path[i] == '[') {
      end_word();
      const std::size_t close = path.find(']', i);
      if (close == std::string::npos) return std::nullopt;
      out.push_back(path.substr(i, close - i));
      i = close;
    } else {
      word += path[i];
    }
  }
  end_word();
  return out;
}

const toml::node* entry(const toml::node& list, const std::string& which) {
  const toml::array* array = list.as_array();
  if (!array)
    return which == "0" && list.is_table() ? &list : nullptr;  // a single table may stand for a list of one
  for (const toml::node& node : *array)
    if (name_in(node) == which) return &node;
  std::size_t place = 0;
  const auto [end, problem] = std::from_chars(which.data(), which.data() + which.size(), place);
  if (problem != std::errc() || end != which.data() + which.size() || place >= array->size()) return nullptr;
  return array->get(place);
}

const toml::node* step_into(const toml::node& node, const std::string& step) {
  if (step.starts_with('[')) return entry(node, step.substr(1));
  const toml::table* table = node.as_table();
  return table ? table->get(step) : nullptr;
}

/// The unique solid, effort or constraint of that name.
const toml::node* named(const toml::table& root, const std::string& name) {
  const toml::node* found = nullptr;
  for (const std::string_view list : lists)
    if (const toml::node* here = root.get(list))
      if (const toml::array* array = here->as_array())
        for (const toml::node& node : *array)
          if (name_in(node) == name) {
            if (found) return nullptr;
            found = &node;
          }
  return found;
}

/// The node at a path, or null.
const toml::node* find(const toml::table& root, const std::string& path) {
  const auto steps = steps_of(path);
  if (!steps || steps->empty()) return nullptr;
  const toml::node* node = root.get(steps->front());
  if (!node) node = named(root, steps->front());
  for (std::size_t i = 1; node && i < steps->size(); ++i) node = step_into(*node, (*steps)[i]);
  return node;
}

void gather(const toml::node& node, const std::string& path, std::vector<std::string>& out) {
  if (is_number(node)) {
    out.push_back(path);
  } else if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table)
      gather(value, path.empty() ? std::string(key.str()) : fmt::format("{}.{}", path, key.str()), out);
  } else if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i) {
      const std::string name = name_in(*array->get(i));
      gather(*array->get(i), fmt::format("{}[{}]", path, name.empty() ? std::to_string(i) : name), out);
    }
  }
}

tl::unexpected<Error> no_number(const toml::table& root, const std::string& file, const std::string& path) {
  std::vector<std::string> all;
  gather(root, "", all);
  // numbers of the named object come first: for "spring.k" all of the spring's
  const std::string of = fmt::format("[{}].", path.substr(0, path.rfind('.')));
  const auto far = [&](const std::string& number) {
    return std::pair(number.find(of) == std::string::npos, edit_distance(number, path));
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const std::string& a, const std::string& b) { return far(a) < far(b); });
  all.resize(std::min(all.size(), most_suggested));
  return bad_use(file, all.empty() ? fmt::format("contains no number, so none at '{}'", path)
                                   : fmt::format("has no number at '{}'; the nearest are {}", path,
                                                 fmt::join(all, ", ")));
}

/// Offset of a position in a text; columns count characters, not bytes.
std::size_t offset_of(std::string_view text, const toml::source_position& at) {
  std::size_t i = 0;
  for (toml::source_index line = 1; line < at.line; ++line) i = text.find('\n', i) + 1;
  for (toml::source_index column = 1; column < at.column && i < text.size(); ++column) {
    ++i;
    while (i < text.size() && (text[i] & 0xC0) == 0x80) ++i;
  }
  return i;
}

std::string written(double value) {
  // whole numbers get a decimal point: "-0" and 1e30 would not be read back as they are
  const std::string out = fmt::format("{}", value);
  return out.find_first_of(".en") == std::string::npos ? out + ".0" : out;
}

}  // namespace

Result<double> number_at(std::string_view text, const std::string& file, const std::string& path) {
  const auto root = parse_toml(text, file);
  if (!root) return tl::unexpected(root.error());
  const toml::node* node = find(*root, path);
  if (!node || !is_number(*node)) return no_number(*root, file, path);
  return value_of(*node);
}

Result<std::string> with_number(std::string_view text, const std::string& file, const std::string& path,
                                double value) {
  const auto root = parse_toml(text, file);
  if (!root) return tl::unexpected(root.error());
  const toml::node* node = find(*root, path);
  const auto steps = steps_of(path);
  std::string out(text);
  if (!node && steps && steps->size() == 2 && steps->front() == "simulation") {
    const std::string line = fmt::format("{} = {}\n", steps->back(), written(value));
    const toml::node* table = root->get("simulation");
    if (!table) return out + "\n[simulation]\n" + line;
    std::size_t at = out.find('\n', offset_of(text, table->source().begin));
    if (at == std::string::npos) at = out.size(), out += '\n';
    return out.insert(at + 1, line);
  }
  if (!node || !is_number(*node)) return no_number(*root, file, path);
  const std::size_t begin = offset_of(text, node->source().begin), end = offset_of(text, node->source().end);
  out.replace(begin, end - begin, written(value));
  return out;
}

}  // namespace borelli
