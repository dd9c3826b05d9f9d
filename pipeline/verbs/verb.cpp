#include "pipeline/verbs/verb.hpp"

#include <algorithm>

namespace borelli {
namespace {

void add_once(std::vector<std::string>& all, const std::string& sentence) {
  if (!sentence.empty() && std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
}

}  // namespace

void group_options(CLI::App& verb, const std::string& title, const std::vector<std::string>& options) {
  for (const std::string& option : options) verb.get_option(option)->group(title);
}

void Command::warn(const std::string& sentence) const { add_once(messages_->warnings, sentence); }

void Command::warn_first(const std::vector<std::string>& sentences) const {
  const std::vector<std::string> before = std::exchange(messages_->warnings, {});
  warn(sentences);
  warn(before);
}

void Command::warn(const std::vector<std::string>& sentences) const {
  for (const std::string& sentence : sentences) warn(sentence);
}

std::vector<std::string> Command::warnings_in_files() const {
  const InputNames as = names();
  std::vector<std::string> out;
  for (const std::string& warning : messages_->warnings) add_once(out, as.without_folders(warning));
  return out;
}

void Command::note(const std::string& sentence) const { add_once(messages_->notes, sentence); }

void Command::add_to_answer(const std::string& name, const nlohmann::json& lists) const {
  for (const auto& [key, list] : lists.items()) {
    nlohmann::json& all = messages_->added[name][key];
    if (all.is_null()) all = nlohmann::json::array();
    for (const nlohmann::json& entry : list)
      if (std::ranges::find(all, entry) == all.end()) all.push_back(entry);
  }
}

nlohmann::json Command::complete(nlohmann::json answer) const {
  if (!answer.is_object()) return answer;
  answer["warnings"] = messages_->warnings;
  answer.update(messages_->added);
  return answer;
}

}  // namespace borelli
