// body_score: scores segmentation on bodies with known truth (body_score.hpp), as Markdown.
//   body_score [--source phantoms|male|female|all] [--seeds FIRST LAST] [--open|--sealed] [--list]
//   [--open-sealed] [--forest FILE]
// Even seeds are the open half, odd ones the sealed half. Only totals of the sealed half are printed, never
// kinds of scans or failures, unless --open-sealed is given. --list: failures of the open half by kind.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/proposal/forest.hpp"
#include "segmentation/volume/held_memory.hpp"
#include "tests/paths.hpp"
#include "tests/suite/body_score.hpp"
#include "tests/suite/warped_bodies.hpp"

namespace {

using namespace borelli;
using suite::BodyScore;

volatile std::sig_atomic_t stopped = 0;
void stop(int) { stopped = 1; }

struct Asked {
  std::uint64_t first = 0, last = 9;
  std::vector<std::string> sources{"phantoms", "male", "female"};
  std::string forest;  // a model file; empty: the program's own
  bool open = true, sealed = true, list = false, open_sealed = false;
};

bool parse(int count, char** words, Asked& asked) {
  for (int n = 1; n < count; ++n) {
    const std::string word = words[n];
    if (word == "--seeds" && n + 2 < count) {
      asked.first = std::strtoull(words[n + 1], nullptr, 10),
      asked.last = std::strtoull(words[n + 2], nullptr, 10);
      n += 2;
    } else if (word == "--source" && n + 1 < count) {
      const std::string source = words[++n];
      if (source != "all" && source != "phantoms" && source != "male" && source != "female") return false;
      if (source != "all") asked.sources = {source};
    } else if (word == "--forest" && n + 1 < count) {
      asked.forest = words[++n];
    } else if (word == "--open") {
      asked.sealed = false;
    } else if (word == "--sealed") {
      asked.open = false;
    } else if (word == "--list") {
      asked.list = true;
    } else if (word == "--open-sealed") {
      asked.open_sealed = true;
    } else {
      return false;
    }
  }
  return asked.open || asked.sealed;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * double(values.size() - 1)))];
}

std::vector<double> absolute(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  return values;
}

using Table = std::map<std::string, BodyScore>;  // by source and half, or by kind of scan

void print_parts(const Table& table, const char* head) {
  fmt::print(
      "\n| {} | scans | refused | parts there | found | swapped | lost in a neighbour | vanished | declined "
      "| absent "
      "rightly | "
      "invented | Dice median | 5th pct | own bone median | 5th pct | mass error median, % | 95th pct, % |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
      "|\n",
      head);
  for (const auto& [name, s] : table) {
    const auto n = [&](const char* what) { return s.count.contains(what) ? s.count.at(what) : 0; };
    fmt::print(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.1f} "
        "| "
        "{:.1f} |\n",
        name, s.scans, s.refused, n("there"), n("found"), n("swapped"), n("lost"), n("vanished"),
        n("declined"), n("absent rightly"), n("invented"), quantile(s.dice, 0.5), quantile(s.dice, 0.05),
        quantile(s.own_bone, 0.5), quantile(s.own_bone, 0.05), 100 * quantile(absolute(s.mass), 0.5),
        100 * quantile(absolute(s.mass), 0.95));
  }
}

double percent_within(const std::vector<double>& ratios, double most) {
  const auto held = std::count_if(ratios.begin(), ratios.end(), [&](double r) { return r <= most; });
  return 100.0 * double(held) / std::max<double>(1, double(ratios.size()));
}

void print_landmarks(const Table& table) {
  fmt::print(
      "\n| source | landmark | found | median, mm | 95th pct, mm | within 1 deviation, % | within 2, % | "
      "within 5, % |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const auto& [name, s] : table)
    for (const auto& [landmark, errors] : s.landmark) {
      const std::vector<double>& ratios = s.landmark_honesty.at(landmark);
      fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.0f} | {:.0f} | {:.0f} |\n", name, landmark,
                 errors.size(), quantile(errors, 0.5), quantile(errors, 0.95), percent_within(ratios, 1),
                 percent_within(ratios, 2), percent_within(ratios, 5));
    }
}

void print_honesty(const Table& table) {
  fmt::print(
      "\n| source | of | errors | within 1 deviation, % | within 2, % | within 5, % | bad misses | silent | "
      "joints "
      "lost |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const auto& [name, s] : table) {
    const auto n = [&](const char* what) { return s.count.contains(what) ? s.count.at(what) : 0; };
    const auto row = [&](const char* of, const std::vector<double>& ratios) {
      fmt::print("| {} | {} | {} | {:.0f} | {:.0f} | {:.0f} | {} | {} | {} |\n", name, of, ratios.size(),
                 percent_within(ratios, 1), percent_within(ratios, 2), percent_within(ratios, 5),
                 n("bad misses"), n("silent"), n("joint lost"));
    };
    row("joint coordinates", s.joint_honesty), row("cuts", s.cut_honesty), row("masses", s.mass_honesty);
  }
}

}  // namespace

int main(int count, char** words) {
  borelli::hold_freed_memory();
  Asked asked;
  if (!parse(count, words, asked)) {
    fmt::print(
        stderr,
        "body_score [--source phantoms|male|female|all] [--seeds FIRST LAST] [--open|--sealed] [--list] "
        "[--open-sealed] [--forest FILE]\n");
    return 2;
  }
  std::optional<Forest> forest;
  if (!asked.forest.empty()) {
    auto read = read_forest(asked.forest);
    if (!read) {
      fmt::print(stderr, "{}\n", read.error().message());
      return 1;
    }
    forest = *std::move(read);
  }
  std::signal(SIGINT, stop), std::signal(SIGTERM, stop);
  Table totals;
  std::map<std::string, Table> kinds;  // by source
  for (const std::string& source : asked.sources) {
    if (stopped) break;
    std::optional<suite::LabelledBody> body;
    if (source != "phantoms") {
      auto read = suite::read_labelled_body(source == "male" ? "am" : "af", test::shared_folder());
      if (!read) {
        fmt::print(stderr, "{}\n", read.error().message());
        continue;
      }
      body = std::move(*read);
    }
    for (std::uint64_t seed = asked.first; seed <= asked.last && !stopped; ++seed) {
      const bool sealed = seed % 2;
      if (sealed ? !asked.sealed : !asked.open) continue;
      const bool shown = !sealed || asked.open_sealed;
      try {
        const suite::TrueScan scan =
            body ? suite::warped_body(*body, suite::fitting_warp(*body, seed)) : suite::drawn_phantom(seed);
        const BodyScore score = suite::score_body(scan, forest ? &*forest : nullptr);
        totals[source + (sealed ? ", sealed" : ", open")] += score;
        fmt::print(stderr, "{} ({:.1f} s)\n", shown ? scan.what : fmt::format("{} seed {}", source, seed),
                   score.seconds);
        if (!shown) continue;
        for (const std::string& kind : scan.kinds) kinds[source][kind] += score;
        if (asked.list)
          for (const suite::Missed& missed : score.missed)
            fmt::print("- {} {}: {}{}\n", source, seed, missed.what, missed.silent ? " (silent)" : "");
        std::fflush(stdout);
      } catch (const std::exception& error) {
        fmt::print(stderr, "{} seed {}: {}\n", source, seed, error.what());
      }
    }
  }
  print_parts(totals, "source");
  for (const auto& [source, table] : kinds) print_parts(table, (source + ": kind of scan").c_str());
  print_landmarks(totals);
  print_honesty(totals);
  return 0;
}
