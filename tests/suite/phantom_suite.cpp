// phantom_suite: the table of all hard cases, as Markdown (its output is in segmentation/phantoms.md).
//   phantom_suite [--misses FILE] [CASE ...]
// CASE: only these. FILE: receives the misses, one per line (tests/suite/misses.txt, which the test reads).
#include "tests/suite/phantom_suite.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

#include "segmentation/volume/held_memory.hpp"

namespace {

using namespace borelli;

std::string plain(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

void print_row(const suite::Case& asked, const suite::Score& score) {
  std::size_t dice = 0, mass = 0;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (score.judged[n] && (dice == 0 || score.dice[n] < score.dice[dice])) dice = n;
    if (score.whole[n] && (mass == 0 || std::abs(score.mass_error[n]) > std::abs(score.mass_error[mass])))
      mass = n;
  }
  std::string joint;
  double hip = -1;
  for (const auto& [name, error] : score.joint_error) {
    if (name.starts_with("hip"))
      hip = std::max(hip, error);
    else if (joint.empty() || error > score.joint_error.at(joint))
      joint = name;
  }
  const auto millimetres = [](double error) {
    return error > 900 ? std::string("lost") : fmt::format("{:.1f}", error);
  };
  std::vector<std::string> misses;
  for (const std::string& miss : score.misses) {
    const bool silent = std::find(score.silent.begin(), score.silent.end(), miss) != score.silent.end();
    misses.push_back(plain(miss) + (silent ? " (untold)" : ""));
  }
  fmt::print("| {} | {:.3f} {} | {} | {} | {} | {} |\n", asked.what, score.dice[dice],
             plain(std::string(parts[dice].name)),
             joint.empty() ? "" : millimetres(score.joint_error.at(joint)) + " " + plain(joint),
             hip < 0 ? "" : millimetres(hip),
             mass == 0 ? ""
                       : fmt::format("{:+.1f} {}", 100 * score.mass_error[mass],
                                     plain(std::string(parts[mass].name))),
             misses.empty() ? "none" : fmt::format("{}", fmt::join(misses, ", ")));
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  borelli::hold_freed_memory();
  std::vector<std::string> chosen(words + 1, words + count);
  std::ofstream list;
  if (chosen.size() > 1 && chosen[0] == "--misses") {
    list.open(chosen[1]);
    if (!list) {
      fmt::print(stderr, "{} cannot be written\n", chosen[1]);
      return 1;
    }
    chosen.erase(chosen.begin(), chosen.begin() + 2);
  }
  fmt::print(
      "| case | worst Dice | worst joint, mm | hips, mm | worst mass, % | misses |\n"
      "| --- | --- | --- | --- | --- | --- |\n");
  for (const suite::Case& asked : suite::cases()) {
    if (!chosen.empty() && std::find(chosen.begin(), chosen.end(), asked.name) == chosen.end()) continue;
    try {
      const suite::Score score = suite::score(asked);
      for (const std::string& miss : score.misses) list << asked.name << ": " << miss << "\n";
      print_row(asked, score);
      fmt::print(stderr, "{}: {:.1f} s\n", asked.name, score.seconds);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      return 1;
    }
  }
  return 0;
}
