#include "pipeline/verbs/manual.hpp"

#include <fmt/ranges.h>

#include <vector>

#include "pipeline/verbs/help.hpp"

namespace borelli {
namespace {

// Text for troff: hyphens stay ASCII, and no line starts a request.
std::string in_troff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (out.empty() || out.back() == '\n') {
      if (c == '.' || c == '\'') out += "\\&";
    }
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

// all names of an option with their dashes
std::vector<std::string> flags_of(const CLI::Option& option) {
  std::vector<std::string> flags;
  for (const std::string& name : option.get_snames()) flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) flags.push_back("--" + name);
  return flags;
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  std::vector<const CLI::Option*> shown;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty()) shown.push_back(option);  // no group: hidden
  return shown;
}

std::string option_entry(const CLI::Option& option) {
  std::string head;
  for (const std::string& flag : flags_of(option))
    head += fmt::format("{}\\fB{}\\fR", head.empty() ? "" : ", ", in_troff(flag));
  if (head.empty())
    head = fmt::format("\\fI{}\\fR", in_troff(option.get_name(true)));
  else if (const std::string value = value_name(option); !value.empty())
    head += fmt::format(" \\fI{}\\fR", in_troff(value));
  return fmt::format(".TP\n{}\n{}\n", head, in_troff(meaning_of(option)));
}

std::string verb_section(const CLI::App& verb) {
  std::string title = "borelli " + verb.get_name();
  for (const CLI::Option* option : options_of(verb))
    if (flags_of(*option).empty()) title += " " + option->get_name(true);
  std::string text = fmt::format(".SS \"{}\"\n{}.\n", in_troff(title), in_troff(verb.get_description()));
  std::string group = "Options";
  for (const std::string& heading : verb.get_groups())
    for (const CLI::Option* option : options_of(verb)) {
      if (option == verb.get_help_ptr() || option->get_group() != heading) continue;
      if (heading != group) text += fmt::format(".PP\n\\fI{}\\fR\n", in_troff(heading));
      group = heading;
      text += option_entry(*option);
    }
  return text;
}

std::string flag_words(const CLI::App& app) {
  std::string words;
  for (const CLI::Option* option : options_of(app))
    for (const std::string& flag : flags_of(*option)) words += (words.empty() ? "" : " ") + flag;
  return words;
}

// "a case of bash: after this option of this verb comes one of these words"
std::string choice_cases(const CLI::App& app, const std::string& verb) {
  std::string cases;
  for (const CLI::Option* option : options_of(app)) {
    const auto words = choices_of(*option);
    if (words.empty()) continue;
    for (const std::string& flag : flags_of(*option))
      cases += fmt::format("    {}:{}) words=\"{}\" ;;\n", verb, flag, fmt::join(words, " "));
  }
  return cases;
}

}  // namespace

std::string manual_page(const CLI::App& program, const std::string& version) {
  std::string page = fmt::format(
      ".TH BORELLI 1 \"\" \"borelli {}\" \"User Commands\"\n"
      ".SH NAME\nborelli \\- {}\n"
      ".SH SYNOPSIS\n\\fBborelli\\fR [\\fIOPTIONS\\fR] \\fIVERB\\fR [\\fIARGUMENTS\\fR]\n"
      ".SH OPTIONS OF ALL VERBS\n",
      version, in_troff(program.get_description()));
  for (const CLI::Option* option : options_of(program)) page += option_entry(*option);
  page += ".SH VERBS\n";
  for (const CLI::App* verb : program.get_subcommands({})) page += verb_section(*verb);
  page +=
      ".SH EXIT STATUS\n.TP\n0\nThe work is done.\n.TP\n1\nThe work failed, or its result is not to be "
      "trusted.\n.TP\n2\nThe command line is wrong.\n";
  return page;
}

std::string bash_completion(const CLI::App& program) {
  std::string verbs, flags, choices = choice_cases(program, "*");
  for (const CLI::App* verb : program.get_subcommands({})) {
    verbs += (verbs.empty() ? "" : " ") + verb->get_name();
    flags += fmt::format("    {}) words=\"{}\" ;;\n", verb->get_name(), flag_words(*verb));
    choices += choice_cases(*verb, verb->get_name());
  }
  return fmt::format(
      "# bash completion for borelli\n"
      "_borelli() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} general=\"{0}\"\n"
      "  local verb= words= i\n"
      "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      "    case \" {1} \" in *\" ${{COMP_WORDS[i]}} \"*) verb=${{COMP_WORDS[i]}}; break ;; esac\n"
      "  done\n"
      "  case $verb:$before in\n{2}  esac\n"
      "  if [ -n \"$words\" ]; then COMPREPLY=($(compgen -W \"$words\" -- \"$word\")); return; fi\n"
      "  case $verb in\n    \"\") words=\"{1}\" ;;\n{3}  esac\n"
      "  if [ -z \"$verb\" ] || [ \"${{word:0:1}}\" = - ]; then\n"
      "    COMPREPLY=($(compgen -W \"$words $general\" -- \"$word\"))\n"
      "  fi\n"
      "}}\n"
      "complete -o default -F _borelli borelli\n",
      flag_words(program), verbs, choices, flags);
}

}  // namespace borelli
