#include "error/json_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <unordered_set>
#include <vector>

#include "error/printable.hpp"

namespace borelli {
namespace {

constexpr std::size_t deepest = 100;  // lists and objects within each other

// The text at fault. `read`: what the parser consumed since the last string or number began.
std::string_view fault_in(std::string_view read) {
  constexpr std::string_view structure = "{}[],:", before = " \t\r\n{}[],:\"";
  if (read.ends_with('"')) return read;  // a string where none may stand
  if (!read.empty() && structure.find(read.back()) != std::string_view::npos)
    return read.substr(read.size() - 1);
  return read.substr(read.find_last_of(before) + 1);
}

// Builds the value from the parser's events.
template <class Json>
class Builder : public nlohmann::json_sax<Json> {
 public:
  using typename nlohmann::json_sax<Json>::number_integer_t;
  using typename nlohmann::json_sax<Json>::number_unsigned_t;
  using typename nlohmann::json_sax<Json>::number_float_t;
  using typename nlohmann::json_sax<Json>::string_t;
  using typename nlohmann::json_sax<Json>::binary_t;

  explicit Builder(std::string_view text) : text_(text) {}

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t& value) override { return put(std::move(value)); }
  bool start_object(std::size_t) override { return put(Json::object()) && enter(); }
  bool start_array(std::size_t) override { return put(Json::array()) && enter(); }
  bool end_object() override { return leave(); }
  bool end_array() override { return leave(); }

  bool key(string_t& name) override {
    if (!open_.back().names.insert(name).second)
      return refuse(fmt::format("\"{}\" appears twice", printable(name)));
    name_ = std::move(name);
    return true;
  }

  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::json::exception& problem) override {
    constexpr int out_of_range = 406;  // nlohmann's out_of_range.406: a number overflows
    position = std::min(std::max<std::size_t>(position, 1) - 1, text_.size());
    line_ = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(position), '\n');
    if (problem.id == out_of_range)
      return refuse(fmt::format("the number {} is too large", printable(token)));
    if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos)
      return refuse("is empty, expected JSON");
    if (position == text_.size()) return refuse("is not JSON: it ends too early and may be cut off");
    return refuse(fmt::format("is not JSON: found '{}'", printable(fault_in(token))));
  }

  Json root;
  std::string what;  ///< why the text was refused

  std::string where(const std::string& file) const {
    return line_ > 0 ? fmt::format("{}:{}", file, line_) : file;
  }

 private:
  bool refuse(std::string sentence) {
    what = std::move(sentence);
    return false;
  }

  template <class Value>
  bool put(Value&& value) {
    if (open_.empty())
      last_ = &(root = std::forward<Value>(value));
    else if (Json& parent = *open_.back().value; parent.is_array())
      last_ = &parent.emplace_back(std::forward<Value>(value));
    else
      last_ = &add_member(parent.template get_ref<typename Json::object_t&>(), std::forward<Value>(value));
    return true;
  }

  // An ordered object is a vector. Its operator[] searches it for each name: quadratic in the members.
  template <class Object, class Value>
  Json& add_member(Object& object, Value&& value) {
    if constexpr (requires { object.back(); })
      return object.Object::Container::emplace_back(name_, std::forward<Value>(value)).second;
    else
      return object[name_] = std::forward<Value>(value);
  }

  bool enter() {
    open_.push_back({last_, {}});
    return open_.size() <= deepest ||
           refuse(fmt::format("lists and objects are nested deeper than {}", deepest));
  }
  bool leave() {
    open_.pop_back();
    return true;
  }

  struct Open {
    Json* value;
    std::unordered_set<std::string> names;  // members of the object so far
  };

  std::string_view text_;
  std::vector<Open> open_;  // from the root to the list or object being read
  Json* last_ = nullptr;
  std::string name_;
  std::ptrdiff_t line_ = 0;
};

template <class Json>
Result<Json> parse(std::string_view text, const std::string& file) {
  Builder<Json> builder(text);
  if (!Json::sax_parse(text, &builder)) return failure(builder.where(file), builder.what);
  return std::move(builder.root);
}

// A sentence about the first value of `document` whose kind differs from the pattern's; empty: none differs.
// `path`: where `document` stands in the whole document.
std::string misfit(const nlohmann::json& document, const nlohmann::json& pattern, const std::string& path) {
  if (pattern.is_null()) return "";
  const bool alike = pattern.is_number() ? document.is_number() : document.type() == pattern.type();
  if (!alike)
    return fmt::format("{} is {}, expected {}", path.empty() ? "the document" : path, kind_of_json(document),
                       pattern.is_object()    ? "an object"
                       : pattern.is_array()   ? "a list"
                       : pattern.is_string()  ? "a text"
                       : pattern.is_boolean() ? "true or false"
                                              : "a number");
  if (pattern.is_object())
    for (const auto& [name, inner] : pattern.items())
      if (const auto found = document.find(name); found != document.end())
        if (auto wrong = misfit(*found, inner, path.empty() ? name : path + "." + name); !wrong.empty())
          return wrong;
  if (pattern.is_array() && !pattern.empty())
    for (std::size_t i = 0; i < document.size(); ++i)
      if (auto wrong = misfit(document[i], pattern[0], fmt::format("{}[{}]", path, i)); !wrong.empty())
        return wrong;
  return "";
}

}  // namespace

Result<nlohmann::json> parse_json(std::string_view text, const std::string& file) {
  return parse<nlohmann::json>(text, file);
}

Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text, const std::string& file) {
  return parse<nlohmann::ordered_json>(text, file);
}

Result<void> check_kinds(const nlohmann::json& document, const nlohmann::json& pattern,
                         const std::string& file) {
  if (std::string wrong = misfit(document, pattern, ""); !wrong.empty())
    return failure(file, std::move(wrong));
  return {};
}

std::string kind_of_json(const nlohmann::json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  if (value.is_string())
    return fmt::format("the text \"{}\"", printable(value.get_ref<const std::string&>()));
  if (value.is_number()) return fmt::format("the number {}", value.get<double>());
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  return "null";
}

}  // namespace borelli
