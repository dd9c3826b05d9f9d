#include "pipeline/verbs/verb.hpp"

#include <algorithm>
#include <utility>

namespace borelli {

void Command::warn(const std::string& sentence) const {
  auto& all = said_->warnings;
  if (!sentence.empty() && std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
}

void Command::warn(const std::vector<std::string>& sentences) const {
  for (const std::string& sentence : sentences) warn(sentence);
}

void Command::answer_with(const char* key, nlohmann::json value) const {
  nlohmann::json& held = said_->more[key];
  if (held.is_array() && value.is_array())
    held.insert(held.end(), value.begin(), value.end());
  else
    held = std::move(value);
}

nlohmann::json Command::with_what_was_said(nlohmann::json answer) const {
  if (!answer.is_object()) return answer;
  answer["warnings"] = said_->warnings;
  answer.update(said_->more);
  return answer;
}

}  // namespace borelli
