#include "tests/mutation/reader.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <exception>
#include <fstream>
#include <functional>
#include <iterator>
#include <new>
#include <string_view>

#include "pipeline/verbs/verb.hpp"

namespace borelli::mutation {
namespace {

// Words that occur only in errors of the libraries and of the standard library.
constexpr std::array library_words{"json.exception",
                                   "filesystem error",
                                   "basic_string",
                                   "std::",
                                   "vector::",
                                   "toml::",
                                   "toml++",
                                   "H5",
                                   "HDF5-DIAG",
                                   "CLI::",
                                   "bad_alloc",
                                   "bad_cast",
                                   "bad_variant",
                                   "bad optional",
                                   "bad_function",
                                   "map::at",
                                   "_M_range",
                                   "regex_error",
                                   "stod",
                                   "stoi",
                                   "stol",
                                   "stoul",
                                   "gdcm",
                                   "itk::",
                                   "vtk",
                                   "Eigen",
                                   "unordered_map",
                                   "fmt::",
                                   "format_error",
                                   "terminate called",
                                   "Assertion",
                                   "__",
                                   "tl::",
                                   "nlohmann",
                                   "XML_",
                                   "zlib",
                                   "sunmatrix",
                                   "CVODE",
                                   "ARKODE",
                                   "parse error at"};

// The message without its quotations: words from the file are not a library's.
std::string without_quotations(std::string_view message) {
  std::string out;
  while (!message.empty()) {
    const char c = message.front();
    const bool opens = (c == '"' || c == '\'') && (out.empty() || out.back() == ' ' || out.back() == '(');
    const std::size_t end = opens ? message.find(c, 1) : 0;
    if (end == message.npos) break;  // an unfinished quotation extends to the end
    if (!opens) out += c;
    message.remove_prefix(end + 1);
  }
  return out;
}

// The message without the names of the case's files: a mutation may choose them.
std::string without_names(std::string message, std::vector<std::string> names) {
  std::ranges::sort(names, std::greater<>(), &std::string::size);  // longest first
  for (const std::string& name : names)
    for (std::size_t at = name.empty() ? message.npos : message.find(name); at != message.npos;
         at = message.find(name, at + 1))
      message.replace(at, name.size(), " ");
  return message;
}

// Whether a file contains these words, for quotations whose end the file's own quotation marks hide.
bool a_file_holds(const std::filesystem::path& folder, const std::string& words) {
  return std::ranges::any_of(std::filesystem::directory_iterator(folder), [&](const auto& entry) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    return bytes.find(words) != std::string::npos;
  });
}

bool is_sentence(const std::string& what) {
  const auto letters = std::ranges::count_if(what, [](unsigned char c) { return std::isalpha(c); });
  return letters >= 8 && std::ranges::count(what, ' ') >= 2;
}

}  // namespace

const std::vector<Reader>& readers() {
  static const std::vector<Reader> all{
#define BORELLI_READER(name) name##_reader(),
#include "tests/mutation/readers.def"
  };
  return all;
}

const Reader* find_reader(std::string_view name) {
  const auto found = std::ranges::find(readers(), name, &Reader::name);
  return found == readers().end() ? nullptr : &*found;
}

tl::unexpected<Error> defect(const std::string& what) { return failure(std::string(defect_place), what); }

std::string fault_in(const Error& error, const std::filesystem::path& file) {
  const std::string message = error.message();
  if (error.where == defect_place) return message;
  const std::filesystem::path folder = file.parent_path();  // somewhere below a folder with a random name
  std::vector<std::string> names{folder.string(), folder.filename().string()};
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  const std::string own_words = without_quotations(without_names(message, names));
  for (const char* words : library_words)
    if (own_words.find(words) != std::string::npos && !a_file_holds(folder, words))
      return std::string("a library's words (") + words + "): " + message;
  if (!is_sentence(error.what)) return "no sentence: " + message;
  if (std::ranges::none_of(names, [&](const auto& name) { return message.find(name) != message.npos; }))
    return "no file is named: " + message;
  return "";
}

std::string fault_in_reading(const Reader& reader, const std::filesystem::path& file, bool& refused,
                             std::string& said) {
  refused = false;
  try {
    const Result<void> answer = reader.read(file);
    if (answer) return "";
    refused = true;
    said = answer.error().message();
    return fault_in(answer.error(), file);
  } catch (const std::bad_alloc&) {
    return "an exception: out of memory";
  } catch (const std::exception& thrown) {
    return std::string("an exception: ") + thrown.what();
  } catch (...) {
    return "an exception of unknown type";
  }
}

Result<void> run_verb(const std::vector<std::string>& words) {
  CLI::App program{"", "borelli"};
  Command command;
  command.json = true;
  add_info(program, command);
  add_evaluate(program, command);
  add_report(program, command);
  program.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes words from the end
  const auto answer = command.work(command);
  if (!answer) return tl::unexpected(answer.error());
  // like the program, replaces bytes that are not UTF-8
  static_cast<void>(answer->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  return {};
}

}  // namespace borelli::mutation
