// The `borelli` program: reads the command line, runs one verb, reports errors in one sentence.
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

#include "error/json_text.hpp"
#include "error/nearest_name.hpp"
#include "error/printable.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/help.hpp"
#include "pipeline/verbs/manual.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/say.hpp"
#include "pipeline/verbs/settings.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"
#include "segmentation/volume/held_memory.hpp"
#include "threads/slabs.hpp"

namespace {

// Says that no option takes a word, and which flag may be meant.
std::string unknown_word(std::string word, const CLI::App& program, const CLI::App& verb) {
  word = borelli::printable(word);
  if (!word.starts_with('-')) return fmt::format("unexpected word '{}'", word);
  std::vector<std::string> flags;
  for (const CLI::App* app : {&program, &verb})
    for (const CLI::Option* option : app->get_options())
      for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  const auto meant = borelli::nearest_name(word, flags);
  return fmt::format("unknown flag {}{}", word, meant ? fmt::format("; did you mean {}?", *meant) : "");
}

// What to give for a missing option: its value and its meaning. CLI11's sentence begins with its name. An
// unknown flag comes first, since it may be the missing one, mistyped.
std::string missing_option(const std::string& message, const CLI::App& program, const CLI::App& verb) {
  for (const std::string& word : program.remaining(true))
    if (word.starts_with('-')) return unknown_word(word, program, verb);
  for (const CLI::Option* option : verb.get_options())
    if (message == option->get_name() + " is required")
      return fmt::format("{}{} is required: {}", option->get_name(),
                         option->nonpositional() ? " " + option->get_type_name() : "",
                         option->get_description());
  return message;
}

// CLI11's sentence in plain words
std::string in_plain_words(const CLI::ParseError& e, const CLI::App& program, const CLI::App& verb) {
  std::string message = e.what();
  const std::string kind = e.get_name();
  // (CLI11 lists the words last to first)
  if (dynamic_cast<const CLI::ExtrasError*>(&e))
    return unknown_word(message.substr(message.rfind(' ') + 1), program, verb);
  if (kind == "RequiredError") return missing_option(message, program, verb);
  if (const auto at = message.find(" excludes "); kind == "ExcludesError" && at != message.npos)
    return message.replace(at, 10, " cannot be combined with ");
  if (const auto at = message.find(": ");
      kind == "ArgumentMismatch" && at != message.npos && message.ends_with(" missing"))
    return message.substr(0, at) + ": needs a value";
  return message;
}

// the error in the command line, or in the settings file with its line
std::string bad_use_of(const CLI::ParseError& e, const CLI::App& program, const CLI::Option* settings_file) {
  if (e.get_name() == "SettingsError") return settings_file->results().front() + e.what();
  if (program.get_subcommands().empty()) return fmt::format("{} (see borelli --help)", e.what());
  const CLI::App& verb = *program.get_subcommands().front();
  return fmt::format("{} (see borelli {} --help)", in_plain_words(e, program, verb), verb.get_name());
}

// an option with an empty value: an unset shell variable
std::string empty_option(const CLI::App& program) {
  for (const CLI::App* verb : program.get_subcommands())
    for (const CLI::Option* option : verb->get_options())
      for (const std::string& value : option->results())
        if (value.empty()) return option->get_name();
  return "";
}

// A sentence as one line of a terminal. It may quote a file: control characters become '?', and overlong
// sentences are truncated.
std::string one_line(std::string sentence) {
  constexpr std::size_t longest = 2000;
  if (sentence.size() > longest) sentence = sentence.substr(0, longest) + "...";
  for (char& c : sentence)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  return sentence;
}

std::string hint_at_verb(const CLI::App& program, const std::string& mistyped) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : program.get_subcommands({})) verbs.push_back(verb->get_name());
  const auto meant = borelli::nearest_name(mistyped, verbs);
  return meant ? fmt::format("; did you mean {}?", *meant) : " (see borelli --help)";
}

constexpr std::uint64_t least_memory = 100'000'000;  // bytes; the program alone needs about half

std::string memory_size(const std::string& text) {
  if (text.empty()) return "";  // handled by empty_option
  const auto bytes = borelli::bytes_from(text);
  if (!bytes)
    return fmt::format("'{}' is not an amount of memory; expected a number and a unit, e.g. 4G or 500M",
                       text);
  return *bytes < least_memory ? fmt::format("'{}' is too little; expected 100M or more", text) : "";
}

void add_general_options(CLI::App& program, borelli::Command& command, std::string& max_memory) {
  program.set_version_flag("--version", "borelli " BORELLI_VERSION "\n" BORELLI_LIBRARIES);
  // (what they print ends the parsing as --version does)
  program.add_flag_callback(
      "--manual",
      [&program] { throw CLI::CallForVersion(borelli::manual_page(program, BORELLI_VERSION), 0); },
      "Print the manual page, in troff");
  program.add_flag_callback(
      "--completion", [&program] { throw CLI::CallForVersion(borelli::bash_completion(program), 0); },
      "Print a script that completes the command line in bash");
  program.add_flag("--json", command.json, "Print the answer as JSON on standard output");
  program.add_option("--threads", command.threads, "Number of threads; 0: all cores")
      ->check(borelli::whole_number_within(0, 1024))
      ->capture_default_str();
  program
      .add_option("--max-memory", max_memory,
                  "Largest amount of memory to use, e.g. 4G (default: three quarters of the free memory)")
      ->type_name("SIZE")
      ->check(memory_size);
  program.add_flag("--force", command.force, "Repeat stages even if their results exist");
}

// returns the option that names the file
CLI::Option* add_settings_file(CLI::App& program) {
  auto* settings_file = program.set_config("--settings", "", "TOML file of settings with one table per verb");
  settings_file->type_name("FILE")->check([](const std::string& path) {
    const auto fine =
        path.empty() ? borelli::Result<void>() : borelli::check_input_file(path, borelli::most_text_bytes);
    return fine ? std::string() : fine.error().message();
  });
  program.config_formatter(std::make_shared<borelli::TomlSettings>(program));
  program.allow_config_extras(CLI::config_extras_mode::error);
  return settings_file;
}

void add_verbs(CLI::App& program, borelli::Command& command) {
  borelli::add_run(program, command);
  borelli::add_phantom(program, command);
  borelli::add_segment(program, command);
  borelli::add_inertia(program, command);
  borelli::add_skeleton(program, command);
  borelli::add_simulate(program, command);
  borelli::add_scale(program, command);
  borelli::add_ik(program, command);
  borelli::add_id(program, command);
  borelli::add_evaluate(program, command);
  borelli::add_equilibrium(program, command);
  borelli::add_modes(program, command);
  borelli::add_convert(program, command);
  borelli::add_export(program, command);
  borelli::add_report(program, command);
  borelli::add_figures(program, command);
  borelli::add_chart(program, command);
  borelli::add_stability(program, command);
  borelli::add_economy(program, command);
  borelli::add_info(program, command);
  for (auto* verb : program.get_subcommands({})) {
    verb->allow_config_extras(CLI::config_extras_mode::error);
    verb->footer(
        "Every verb also takes --json, --threads, --max-memory, --force and --settings: see borelli --help.");
  }
}

// The options that name files or folders to write.
constexpr std::array output_options{"--output", "--checkpoint", "--video", "--errors", "--powers"};

bool names_output(const CLI::Option& option) {
  return std::ranges::any_of(output_options, [&](const char* name) { return option.check_lname(name + 2); });
}

// What the command line gives as files and folders, except outputs.
std::vector<std::string> inputs_of(const CLI::App& verb) {
  std::vector<std::string> inputs;
  for (const CLI::Option* option : verb.get_options()) {
    const std::string type = option->get_type_name();
    const bool path = option->get_positional() || type.ends_with("FILE") || type.ends_with("FOLDER");
    if (!path || names_output(*option)) continue;
    inputs.insert(inputs.end(), option->results().begin(), option->results().end());
  }
  return inputs;
}

// Whether the command line names no file twice as an output, and none as both input and output.
borelli::Result<void> check_outputs(const CLI::App& verb, const std::vector<std::string>& inputs) {
  namespace fs = std::filesystem;
  const auto same_file = [](const fs::path& a, const fs::path& b) {
    std::error_code problem;
    return !fs::is_directory(a, problem) && fs::weakly_canonical(fs::absolute(a, problem), problem) ==
                                                fs::weakly_canonical(fs::absolute(b, problem), problem);
  };
  std::vector<std::pair<std::string, std::string>> outputs;  // option, path
  for (const CLI::Option* option : verb.get_options())
    if (names_output(*option))
      for (const std::string& path : option->results()) outputs.emplace_back(option->get_name(), path);
  for (auto one = outputs.begin(); one != outputs.end(); ++one) {
    for (auto other = outputs.begin(); other != one; ++other)
      if (same_file(one->second, other->second))
        return borelli::bad_use(
            one->second,
            fmt::format("is named for two outputs ({} and {}); name two files", other->first, one->first));
    for (const std::string& input : inputs)
      if (same_file(one->second, input))
        return borelli::bad_use(one->second, "is an input of this command; name another file");
  }
  return {};
}

int run(int argc, char** argv) {
  borelli::Command command;
  std::string max_memory;
  CLI::App program{"Turn a CT or MR volume of a person into a body that moves", "borelli"};
  program.require_subcommand(1);
  program.fallthrough();
  program.formatter(std::make_shared<borelli::HelpLayout>());  // verbs inherit it
  add_general_options(program, command, max_memory);
  const auto* settings_file = add_settings_file(program);
  add_verbs(program, command);

  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return program.exit(e);  // --help, --version
    if (argc == 1) {
      fmt::print("{}", program.help());
      return 0;
    }
    if (program.get_subcommands().empty() && argv[1][0] != '-') {
      borelli::say("borelli: {}: unknown verb{}\n", borelli::printable(argv[1]),
                   hint_at_verb(program, argv[1]));
      return 2;
    }
    borelli::say("borelli: {}\n", bad_use_of(e, program, settings_file));
    return 2;
  }

  if (const std::string option = empty_option(program); !option.empty()) {
    borelli::say("borelli: {}: has an empty value; give a value, or leave the option out\n", option);
    return 2;
  }
  borelli::set_memory_limit(borelli::bytes_from(max_memory).value_or(borelli::memory_limit()));
  if (command.threads > 0) borelli::all_threads = command.threads;
  command.inputs = inputs_of(*program.get_subcommands().front());
  const auto apart = check_outputs(*program.get_subcommands().front(), command.inputs);
  const auto answer = apart ? command.work(command) : tl::unexpected(apart.error());
  for (const std::string& warning : command.warnings()) borelli::say("warning: {}\n", one_line(warning));
  if (!command.json)
    for (const std::string& note : command.notes()) borelli::say("note: {}\n", one_line(note));
  if (!answer) {
    borelli::say("borelli: {}\n", one_line(answer.error().message()));
    return answer.error().kind == borelli::Error::Kind::use ? 2 : 1;
  }
  if (command.json) fmt::print("{}\n", borelli::json_text(command.complete(*answer), 2));
  return 0;
}

// Opens standard descriptors that the shell closed; otherwise the next opened file would take their number
// and receive messages. (They are opened for reading, so that writing fails and is noticed.)
void hold_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) < 0) static_cast<void>(open("/dev/null", O_RDONLY));
}

// On a terminating signal: removes partial files, then lets the shell see the signal.
extern "C" void end_by_signal(int signal) {
  borelli::stop_writing();
  if (const char* words = borelli::words_when_stopped()) {
    const auto written = write(STDERR_FILENO, words, std::strlen(words));
    static_cast<void>(written);  // nothing more can be done
  }
  raise(signal);  // SA_RESETHAND restored the default action, which runs when this handler returns
}

void handle_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {
    }, before{};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN) continue;  // nohup, or a shell's background job
    action.sa_handler = end_by_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
  // a file above the allowed size (ulimit -f) is a failed write, not the program's end
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_descriptors();
  handle_signals();
  borelli::hold_freed_memory();
  int code = 1;
  try {
    code = run(argc, argv);
  } catch (const std::bad_alloc&) {
    borelli::say("borelli: {}\n", borelli::out_of_memory("", "this command").value().message());
  } catch (const std::filesystem::filesystem_error& e) {
    borelli::say("borelli: {}: {}\n", e.path1().string(), e.code().message());
  } catch (const std::system_error& e) {
    const bool thread = e.code() == std::errc::resource_unavailable_try_again;
    borelli::say("borelli: {}\n", thread ? "cannot start another thread: the memory or the number of threads "
                                           "is exhausted; give a smaller --threads"
                                         : "the system refused a request: " + e.code().message());
  } catch (...) {  // a library's own message would not help a user
    borelli::say(
        "borelli: stopped by an error of the program itself; please report it with the command and its "
        "input\n");
  }
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  if (code == 0) borelli::say("borelli: cannot write to standard output: {}\n", std::strerror(errno));
  return code == 0 ? 1 : code;
}
