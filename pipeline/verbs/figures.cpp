// borelli figures -o DIR: figures of the paper that the engine follows, drawn from our own runs.
#include <fmt/core.h>

#include <filesystem>

#include "pipeline/files/whole_file.hpp"
#include "pipeline/paper/paper_figures.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

Result<nlohmann::json> work(const std::filesystem::path& folder, const Command& command) {
  if (auto fine = check_folder_writable(folder); !fine) return tl::unexpected(fine.error());
  ProgressBar bar(command.json);
  std::string last;
  const PaperFigureSettings settings;
  const auto figures = paper_figures(settings, [&](const std::string& name) {
    if (!last.empty()) bar.end("done");
    bar.begin(last = name);
  });
  if (!figures) return tl::unexpected(figures.error());
  bar.end("done");

  nlohmann::json answer = nlohmann::json::array();
  for (const PaperFigure& figure : *figures) {
    const auto picture = folder / (figure.name + ".svg"), table = folder / (figure.name + ".csv");
    if (const auto done = write_whole(picture, svg(figure.plot)); !done) return tl::unexpected(done.error());
    if (const auto done = write_whole(table, csv(figure.plot)); !done) return tl::unexpected(done.error());
    answer.push_back({{"title", figure.plot.title},
                      {"svg", picture.string()},
                      {"csv", table.string()},
                      {"notes", figure.plot.notes}});
    if (command.json) continue;
    fmt::print("{}  {}\n", picture.string(), figure.plot.title);
    for (const std::string& note : figure.plot.notes) fmt::print("    {}\n", note);
  }
  return answer;
}

}  // namespace

void add_figures(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand(
      "figures", "Draw the paper's figures 2, 3, 4, 6, 7, 8 and 10 from runs of this program");
  auto folder = std::make_shared<std::string>("figures");
  add_output(*verb, *folder, "FOLDER", "Folder for the SVG pictures and the CSV tables of their data")
      ->capture_default_str();
  verb->callback(
      [&command, folder] { command.work = [folder](const Command& c) { return work(*folder, c); }; });
}

}  // namespace borelli
