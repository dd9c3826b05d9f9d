// The verbs of the `borelli` program: each one file here, one function that adds it, one line in the list
// below.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// What every verb shares, and what the command line chose.
struct Command {
  bool json = false;   ///< print the answer as JSON (and nothing else) on standard output
  int threads = 0;     ///< 0: as many as the machine has
  bool force = false;  ///< do again what is there already
  /// The chosen verb's work. Its answer is what --json prints; without --json a verb prints for people
  /// itself.
  std::function<Result<nlohmann::json>(const Command&)> work;

  /// What the user should know of the result, each sentence once, empty ones never: the program prints it as
  /// "warning: ..." on standard error when the work is over, and answers it as "warnings". Verbs read their
  /// inputs by inputs.hpp, which passes on what readers say.
  void warn(const std::string& sentence) const;
  void warn(const std::vector<std::string>& sentences) const;
  const std::vector<std::string>& warnings() const { return said_->warnings; }
  /// Puts what was read into the answer; a list goes on where one stands there.
  void answer_with(const char* key, nlohmann::json value) const;
  /// The answer with all of that.
  nlohmann::json with_what_was_said(nlohmann::json answer) const;

 private:
  struct Said {
    std::vector<std::string> warnings;
    nlohmann::json more = nlohmann::json::object();
  };
  std::shared_ptr<Said> said_ = std::make_shared<Said>();
};

void add_run(CLI::App& program, Command& command);
void add_phantom(CLI::App& program, Command& command);
void add_segment(CLI::App& program, Command& command);
void add_inertia(CLI::App& program, Command& command);
void add_skeleton(CLI::App& program, Command& command);
void add_simulate(CLI::App& program, Command& command);
void add_evaluate(CLI::App& program, Command& command);
void add_equilibrium(CLI::App& program, Command& command);
void add_modes(CLI::App& program, Command& command);
void add_export(CLI::App& program, Command& command);
void add_report(CLI::App& program, Command& command);
void add_figures(CLI::App& program, Command& command);
void add_chart(CLI::App& program, Command& command);
void add_stability(CLI::App& program, Command& command);
void add_economy(CLI::App& program, Command& command);
void add_info(CLI::App& program, Command& command);

}  // namespace borelli
