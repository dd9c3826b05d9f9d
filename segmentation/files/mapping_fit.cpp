#include "segmentation/files/mapping_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/quantity.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {

namespace data {
extern const char* const anatomy;
}

namespace {

enum class ClassSide { any, left, right, middle };
enum class Holds { any, bone, flesh, organ, hollow, lung };

struct ClassPlace {
  int top = 0, bottom = 0;  // levels, counted downwards
  ClassSide side = ClassSide::any;
  double usual_ml = 0;
  Holds holds = Holds::any;
};

int column_level(const std::string& word) {
  static const std::vector<std::string> levels = [] {
    std::vector<std::string> all{"vertex", "skull_base"};
    for (const auto& [letter, count] : {std::pair{'C', 7}, {'T', 12}, {'L', 5}})
      for (int n = 1; n <= count; ++n) all.push_back(fmt::format("{}{}", letter, n));
    for (const char* below : {"sacrum", "hip_joint", "thigh", "knee", "shank", "foot"})
      all.emplace_back(below);
    return all;
  }();
  return static_cast<int>(std::ranges::find(levels, word) - levels.begin());
}

template <std::size_t N>
std::size_t index_in(const std::array<std::string_view, N>& words, const std::string& word) {
  return static_cast<std::size_t>(std::ranges::find(words, word) - words.begin()) % N;
}

// data/anatomy.tsv by plain name
const std::map<std::string, ClassPlace>& anatomy() {
  static const auto all = [] {
    constexpr std::array<std::string_view, 4> sides{"any", "left", "right", "middle"};
    constexpr std::array<std::string_view, 6> kinds{"any", "bone", "flesh", "organ", "hollow", "lung"};
    std::map<std::string, ClassPlace> places;
    std::istringstream text(data::anatomy);
    for (std::string line; std::getline(text, line);) {
      if (line.empty() || line.starts_with('#') || line.starts_with("name\t")) continue;
      std::istringstream row(line);
      std::array<std::string, 6> cell;
      for (std::string& word : cell) std::getline(row, word, '\t');
      places[plain_name(cell[0])] = {column_level(cell[1]), column_level(cell[2]),
                                     static_cast<ClassSide>(index_in(sides, cell[3])), std::stod(cell[4]),
                                     static_cast<Holds>(index_in(kinds, cell[5]))};
    }
    return places;
  }();
  return all;
}

// a class of the map with its name by a mapping
struct NamedClass {
  std::string name;
  ClassPlace usual;
  NumberPlace found;
};

const ClassMapping::Entry* entry_of(const ClassMapping& mapping, std::int64_t number) {
  const auto it = std::ranges::find_if(mapping.entries, [&](const auto& e) { return e.label == number; });
  return it == mapping.entries.end() ? nullptr : &*it;
}

// Whether CT numbers contradict the class. Tolerates thin or demineralised bone, flesh with a vessel or clip,
// and a lung with an effusion.
bool scan_contradicts(const NamedClass& named) {
  const auto& [number, volume, centre, bright, gas] = named.found;
  if (bright < 0) return false;
  switch (named.usual.holds) {
    case Holds::bone:
      return bright < 0.04 || gas > 0.3;
    case Holds::flesh:
      return bright > 0.4 || gas > 0.3;
    case Holds::organ:
      return gas > 0.3;
    case Holds::lung:
      return gas < 0.1;
    default:
      return false;
  }
}

double middle_of(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto half = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, half);
  return *half;
}

// x of the body's midline from midline classes, else midway between left and right; NaN: unknown
double middle_of(const std::vector<NamedClass>& all, double to_left) {
  std::array<std::vector<double>, 4> x;
  for (const NamedClass& named : all)
    x[static_cast<std::size_t>(named.usual.side)].push_back(to_left * named.found.centre[0]);
  const auto of = [&](ClassSide side) { return middle_of(x[static_cast<std::size_t>(side)]); };
  return x[static_cast<std::size_t>(ClassSide::middle)].empty()
             ? (of(ClassSide::left) + of(ClassSide::right)) / 2
             : of(ClassSide::middle);
}

MappingFit fit_turned(const std::vector<NamedClass>& all, double to_left, double up) {
  constexpr int apart = 2;                  // levels; least difference that height can tell
  constexpr double aside = 60, beyond = 5;  // mm, from the body's middle
  constexpr double too_much = 5;            // times the usual volume
  const double middle = middle_of(all, to_left);
  MappingFit fit;
  for (const NamedClass& one : all) {
    std::size_t beside = 0, wrong = 0;
    for (const NamedClass& other : all) {
      const bool above = one.usual.bottom + apart <= other.usual.top,
                 below = other.usual.bottom + apart <= one.usual.top;
      if (!above && !below) continue;
      ++beside;
      wrong += (up * (one.found.centre[2] - other.found.centre[2]) > 0) != above;
    }
    const double x = to_left * one.found.centre[0] - middle;
    const bool sided = one.usual.side != ClassSide::any && std::isfinite(middle);
    const bool astray = sided && (one.usual.side == ClassSide::left    ? x < -beyond
                                  : one.usual.side == ClassSide::right ? x > beyond
                                                                       : std::abs(x) > aside);
    const bool contradicted = scan_contradicts(one) || one.found.volume_ml > too_much * one.usual.usual_ml;
    if (!beside && !sided && !contradicted && one.found.bright < 0) continue;
    ++fit.judged;
    if (2 * wrong > beside || astray || contradicted) fit.misplaced.push_back(one.name);
  }
  return fit;
}

}  // namespace

std::vector<NumberPlace> places_of(const NumberedLabels& labels, const GreyVolume* scan) {
  struct Sums {
    std::int64_t voxels = 0, seen = 0, bright = 0, gas = 0;
    Eigen::Vector3d index = Eigen::Vector3d::Zero();
  };
  std::array<Sums, 256> sums;
  const Grid& g = labels.map.grid;
  const bool ct = scan && scan->quantity != Quantity::mr;
  Eigen::Matrix3d to_scan = Eigen::Matrix3d::Identity();
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  if (ct) to_scan = scan->grid.axes.inverse() * g.axes, start = scan->grid.index(g.origin);
  std::size_t o = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i, ++o) {
        const auto label = labels.map.voxels[o];
        if (!label) continue;
        Sums& sum = sums[label];
        const Eigen::Vector3d index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        ++sum.voxels;
        sum.index += index;
        if (!ct) continue;
        const Eigen::Vector3d at = start + to_scan * index;
        const auto a = std::lround(at[0]), b = std::lround(at[1]), c = std::lround(at[2]);
        if (!scan->grid.holds(a, b, c)) continue;
        const double hu = hu_of(scan->voxels[scan->grid.offset(a, b, c)], scan->quantity);
        ++sum.seen, sum.bright += hu > 150, sum.gas += hu < -300;
      }
  std::vector<NumberPlace> places;
  for (std::size_t label = 1; label < labels.numbers.size(); ++label) {
    const Sums& sum = sums[label];
    if (sum.voxels == 0) continue;
    const auto n = static_cast<double>(sum.voxels);
    NumberPlace place{labels.numbers[label], 1e-3 * n * g.voxel_volume(), g.point(sum.index / n)};
    if (2 * sum.seen > sum.voxels) {
      place.bright = static_cast<double>(sum.bright) / static_cast<double>(sum.seen);
      place.gas = static_cast<double>(sum.gas) / static_cast<double>(sum.seen);
    }
    places.push_back(place);
  }
  return places;
}

MappingFit fit_of(const std::vector<NumberPlace>& places, const ClassMapping& mapping) {
  constexpr double speck = 0.05;  // of the usual volume: smaller regions are network errors
  std::vector<NamedClass> all;
  std::vector<std::string> unknown;
  for (const NumberPlace& place : places) {
    const auto* entry = entry_of(mapping, place.number);
    if (!entry) {
      unknown.push_back(fmt::format("label {}", place.number));
      continue;
    }
    const auto usual = anatomy().find(plain_name(entry->name));
    if (usual == anatomy().end() || place.volume_ml < speck * usual->second.usual_ml) continue;
    all.push_back({entry->name, usual->second, place});
  }
  std::optional<MappingFit> best;
  for (const double up : {1, -1})
    for (const double to_left : {1, -1}) {
      auto fit = fit_turned(all, to_left, up);
      if (!best || fit.misplaced.size() < best->misplaced.size()) best = std::move(fit);
    }
  best->judged += unknown.size();
  best->misplaced.insert(best->misplaced.end(), unknown.begin(), unknown.end());
  return *best;
}

Result<ClassMapping> fitting_mapping(const std::string& where, const std::string& name,
                                     const std::vector<NumberPlace>& places,
                                     std::vector<std::string>& warnings) {
  // Share of misplaced classes: at most 2 % with the right table (ICRP 110, a real scan, the phantom, pieces
  // of them), 20 to 80 % with another version's.
  constexpr double fits = 0.1;
  auto asked = class_mapping(name);
  if (!asked) return asked;
  const MappingFit fit = fit_of(places, *asked);
  const auto few = [](const MappingFit& f) { return f.share() <= fits || f.misplaced.size() < 2; };
  if (fit.share() <= fits) return asked;
  const std::string family = name.substr(0, name.find('_'));
  std::optional<MappingFit> best;
  std::string_view better;
  for (const std::string_view other : ready_mappings) {
    if (other == name) continue;
    const auto mapping = class_mapping(std::string(other));
    if (!mapping) return mapping;
    MappingFit theirs = fit_of(places, *mapping);
    if (!few(theirs) || (best && best->share() <= theirs.share())) continue;
    best = std::move(theirs), better = other;
  }
  // a single misplaced class is the scan's fault, unless another mapping names more classes and none is
  // misplaced
  if (few(fit) && !(best && best->misplaced.empty() && best->judged > fit.judged)) return asked;
  auto which = fit.misplaced;
  if (which.size() > 4) which.resize(4), which.emplace_back("...");
  const std::string found =
      fmt::format("with the mapping {}, {} of its {} classes lie where no body has them ({})", name,
                  fit.misplaced.size(), fit.judged, fmt::join(which, ", "));
  if (better.starts_with(family)) {
    warnings.push_back(fmt::format(
        "{}: {}, and with {} {} of {}; the file has no names for its numbers, so they were read with {}",
        where, found, better, best->misplaced.size(), best->judged, better));
    return class_mapping(std::string(better));
  }
  return bad_use(where, found + (better.empty() ? "; no built-in mapping fits its numbers; name the classes "
                                                  "(--label-names), or give your own mapping"
                                                : fmt::format("; choose {}, which fits", better)));
}

}  // namespace borelli
