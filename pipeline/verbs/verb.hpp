// The verbs of the `borelli` program. Each has its own file, a function that adds it, and a line in the list
// below.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/files/input_names.hpp"

namespace borelli {

/// Options that all verbs share, and the chosen verb.
struct Command {
  bool json = false;                ///< print the answer as JSON (and nothing else) on standard output
  int threads = 0;                  ///< 0: as many as the machine has
  bool force = false;               ///< repeat work that is already done
  bool keep_paths = false;          ///< output files name inputs by whole paths
  std::vector<std::string> inputs;  ///< files and folders that the command line names, except outputs
  /// The chosen verb's work. Returns what --json prints; without --json the verb prints its own text.
  std::function<Result<nlohmann::json>(const Command&)> work;

  /// Warns of what makes the inputs or the result doubtful. An empty or repeated sentence is ignored. The
  /// program prints "warning: ..." on standard error after the work, and adds "warnings" to the JSON answer.
  /// Verbs read their inputs through inputs.hpp, which passes on the readers' warnings.
  void warn(const std::string& sentence) const;
  void warn(const std::vector<std::string>& sentences) const;
  /// Inserts these before all existing warnings, in this order, without duplicates.
  void warn_first(const std::vector<std::string>& sentences) const;
  const std::vector<std::string>& warnings() const { return messages_->warnings; }
  /// How output files name the inputs. (The terminal shows paths as the user gave them.)
  InputNames names() const { return {keep_paths, inputs}; }
  /// The warnings as output files hold them.
  std::vector<std::string> warnings_in_files() const;
  /// Adds a note that may interest the user. The program prints "note: ..." on standard error after the work,
  /// except with --json.
  void note(const std::string& sentence) const;
  const std::vector<std::string>& notes() const { return messages_->notes; }
  /// Appends `lists`, an object of lists, to the member `name` of the JSON answer.
  void add_to_answer(const std::string& name, const nlohmann::json& lists) const;
  /// A verb's answer with "warnings" and the added members.
  nlohmann::json complete(nlohmann::json answer) const;

 private:
  struct Messages {
    std::vector<std::string> warnings, notes;
    nlohmann::json added = nlohmann::json::object();
  };
  std::shared_ptr<Messages> messages_ = std::make_shared<Messages>();  // verbs get a const Command
};

/// Lists these options of a verb under their own title in its help, after the common ones.
void group_options(CLI::App& verb, const std::string& title, const std::vector<std::string>& options);

void add_run(CLI::App& program, Command& command);
void add_phantom(CLI::App& program, Command& command);
void add_segment(CLI::App& program, Command& command);
void add_inertia(CLI::App& program, Command& command);
void add_skeleton(CLI::App& program, Command& command);
void add_simulate(CLI::App& program, Command& command);
void add_scale(CLI::App& program, Command& command);
void add_ik(CLI::App& program, Command& command);
void add_id(CLI::App& program, Command& command);
void add_evaluate(CLI::App& program, Command& command);
void add_equilibrium(CLI::App& program, Command& command);
void add_modes(CLI::App& program, Command& command);
void add_convert(CLI::App& program, Command& command);
void add_export(CLI::App& program, Command& command);
void add_report(CLI::App& program, Command& command);
void add_figures(CLI::App& program, Command& command);
void add_chart(CLI::App& program, Command& command);
void add_stability(CLI::App& program, Command& command);
void add_economy(CLI::App& program, Command& command);
void add_info(CLI::App& program, Command& command);

}  // namespace borelli
