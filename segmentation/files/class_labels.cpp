#include "segmentation/files/class_labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "segmentation/files/mapping_fit.hpp"
#include "segmentation/files/terminology.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

// segments whose class comes from their coded terminology or ID, because the name is unknown or differs
struct OtherNames {
  std::vector<std::string> matched, otherwise;
};

void match_other_names(const ClassMapping& mapping, const std::string& name,
                       const std::vector<std::string>& others, const ClassRule*& rule, OtherNames& coded) {
  for (const std::string& other : others) {
    const ClassRule* theirs = mapping.find(-1, other);
    if (!theirs) continue;
    const auto forms = other_forms(name);
    if (!rule && std::ranges::find(forms, other) != forms.end())
      rule = theirs;
    else if (!rule)
      rule = theirs, coded.matched.push_back(name + " is " + other);
    else if (*theirs != *rule)
      coded.otherwise.push_back(name + " or " + other);
    return;
  }
}

std::string listed(const std::vector<std::string>& words) {
  constexpr std::ptrdiff_t most = 8;
  const auto end = words.begin() + std::min(most, std::ssize(words));
  return fmt::format("{}{}", fmt::join(words.begin(), end, ", "), end == words.end() ? "" : ", ...");
}

}  // namespace

Result<ClassLabels> class_labels(const std::string& where, NumberedLabels labels,
                                 const ClassMapping& mapping) {
  ClassLabels map;
  map.labels = std::move(labels.map);
  for (const std::string& warning : map.labels.warnings) map.warnings.push_back(where + ": " + warning);
  map.rules.resize(map.labels.names.size());
  std::array<std::size_t, 256> voxels{};
  for (const auto label : map.labels.voxels) ++voxels[label];
  std::size_t known = 0, unknown = 0;
  std::string list;
  OtherNames coded;
  for (std::size_t label = 1; label < map.rules.size(); ++label) {
    if (voxels[label] == 0) continue;
    const std::string& name = map.labels.names[label];
    const ClassRule* rule = mapping.find(labels.numbers[label], name);
    const auto other = labels.other_names.find(static_cast<std::uint8_t>(label));
    if (other != labels.other_names.end()) match_other_names(mapping, name, other->second, rule, coded);
    if (rule) {
      map.rules[label] = *rule;
      ++known;
      continue;
    }
    if (++unknown <= 8)
      list +=
          (list.empty() ? "" : ", ") + (name.empty() ? fmt::format("label {}", labels.numbers[label]) : name);
  }
  if (known == 0 && unknown > 0)
    return failure(
        where,
        "none of its classes (" + list +
            ") is in the mapping; choose another --label-mapping, or check the classes' names and numbers");
  for (const auto& [which, what] :
       {std::pair{&coded.matched, "the mapping lacks the name of"},
        {&coded.otherwise, "name and coded terminology (or ID) tell different classes for"}})
    if (!which->empty())
      map.warnings.push_back(fmt::format("{}: {} {} of its segments ({}); the {} is used", where, what,
                                         which->size(), listed(*which),
                                         which == &coded.matched ? "coded terminology or ID" : "name"));
  if (unknown > 0)
    map.warnings.push_back(fmt::format(
        "{}: {} of its classes are not in the mapping ({}{}); their voxels are treated as unlabelled", where,
        unknown, list, unknown > 8 ? ", ..." : ""));
  return map;
}

Result<ClassLabels> read_classes(const std::string& path, const std::string& names,
                                 const std::string& mapping, const GreyVolume* scan,
                                 const Progress& progress) {
  auto rules = class_mapping(mapping);
  if (!rules) return tl::unexpected(rules.error());
  const auto is_used = [&](std::int64_t number, const std::string& name, const auto& others) {
    return rules->find(number, name) ||
           std::ranges::any_of(others, [&](const std::string& other) { return rules->find(-1, other); });
  };
  auto labels = read_numbered_labels(path, names, progress, is_used);
  if (!labels) return tl::unexpected(labels.error());
  std::vector<std::string> warnings;
  const bool ready = std::ranges::find(ready_mappings, mapping) != std::end(ready_mappings);
  if (ready && std::ranges::all_of(labels->map.names,
                                   [](const std::string& name) { return name.empty() || name == "outside"; }))
    rules = fitting_mapping(path, mapping, places_of(*labels, scan), warnings);
  if (!rules) return tl::unexpected(rules.error());
  if (scan)
    if (auto said = in_words(labels_beyond(labels->map, scan->grid), labels->map); !said.empty())
      labels->map.warnings.push_back(std::move(said));
  auto map = class_labels(path, std::move(*labels), *rules);
  if (map) map->warnings.insert(map->warnings.begin(), warnings.begin(), warnings.end());
  return map;
}

namespace {

// Maps the corners of `a` to indices of `b` by turn * index + by. Returns the largest error, in voxels of
// `b`.
double apart(const Grid& a, const Grid& b, const Eigen::Matrix3d& turn, const Eigen::Vector3d& by) {
  double worst = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int n = 0; n < 3; ++n)
      index[n] = (corner >> n & 1) ? static_cast<double>(a.size[static_cast<std::size_t>(n)] - 1) : 0;
    worst = std::max(worst, (b.index(a.point(index)) - turn * index - by).cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

bool same_grid(const Grid& a, const Grid& b) {
  return a.size == b.size && apart(a, b, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()) <= 0.01;
}

bool same_lattice(const Grid& a, const Grid& b) {
  // Each axis of `a` must run along one of `b`: 1 or -1 once in each row and column.
  const Eigen::Matrix3d turn = (b.axes.inverse() * a.axes).array().round();
  return (turn * turn.transpose()).isIdentity() &&
         apart(a, b, turn, b.index(a.origin).array().round().matrix()) <= 0.01;
}

std::map<std::uint8_t, double> labels_beyond(const LabelMap& labels, const Grid& grid) {
  if (same_grid(labels.grid, grid)) return {};
  std::array<std::size_t, 256> all{}, outside{};
  const Eigen::Matrix3d to_index = grid.axes.inverse();
  const Grid& own = labels.grid;
  for (std::int64_t k = 0; k < own.size[2]; ++k)
    for (std::int64_t j = 0; j < own.size[1]; ++j)
      for (std::int64_t i = 0; i < own.size[0]; ++i) {
        const auto label = labels.at(i, j, k);
        if (label == 0) continue;
        const Eigen::Vector3d at = to_index * (own.point(i, j, k) - grid.origin);
        ++all[label];
        outside[label] += !grid.holds(std::lround(at[0]), std::lround(at[1]), std::lround(at[2]));
      }
  std::map<std::uint8_t, double> beyond;
  for (std::size_t label = 1; label < all.size(); ++label)
    if (outside[label] > 0)
      beyond[static_cast<std::uint8_t>(label)] =
          static_cast<double>(outside[label]) / static_cast<double>(all[label]);
  return beyond;
}

std::string in_words(const std::map<std::uint8_t, double>& beyond, const LabelMap& labels) {
  if (beyond.empty()) return "";
  std::vector<std::pair<double, std::uint8_t>> most_first;
  for (const auto& [label, share] : beyond) most_first.emplace_back(-share, label);
  std::ranges::sort(most_first);
  std::vector<std::string> which;
  for (const auto& [share, label] : most_first) {
    const std::string& name = labels.names[label];
    which.push_back(
        fmt::format("{} {:.3g} %", name.empty() ? fmt::format("label {}", label) : name, -100 * share));
  }
  return "voxels outside the scan were left out: " + listed(which);
}

LabelMap labels_on(const LabelMap& labels, const Grid& grid, int threads) {
  LabelMap out{{grid, {}}, labels.names, labels.warnings};
  if (same_grid(grid, labels.grid)) {
    out.voxels = labels.voxels;
    return out;
  }
  out.voxels.assign(grid.count(), 0);
  const Eigen::Matrix3d to_index = labels.grid.axes.inverse();
  in_slabs(grid.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < grid.size[1]; ++j)
        for (std::int64_t i = 0; i < grid.size[0]; ++i) {
          const Eigen::Vector3d at = to_index * (grid.point(i, j, k) - labels.grid.origin);
          const auto a = std::lround(at[0]), b = std::lround(at[1]), c = std::lround(at[2]);
          if (labels.grid.holds(a, b, c)) out.at(i, j, k) = labels.at(a, b, c);
        }
  });
  return out;
}

}  // namespace borelli
