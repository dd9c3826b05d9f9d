// forest_features: features and part labels of voxels drawn from many bodies, for segmentation/training.
//   forest_features --out FOLDER [--seed S] [--views V] [--samples N] [--phantoms FIRST LAST] [FOLDER ...]
// Each body (a folder with scan.nii.gz and parts.nii.gz, or the phantom of a seed) is used unchanged and in
// V - 1 more views (drawn_views.hpp); N voxels are drawn from each view. The folder of --out then holds
// features.npy (int16, N x features), parts.npy (uint8), bodies.npy (int32: the body's number) and names.txt
// (the names of features and bodies).

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "segmentation/proposal/voxel_features.hpp"
#include "segmentation/volume/held_memory.hpp"
#include "segmentation/volume/nearest_whole.hpp"
#include "tests/suite/drawn_views.hpp"

namespace {

using namespace borelli;

struct Asked {
  std::string out;
  std::uint64_t seed = 1, first_phantom = 1, last_phantom = 0;
  int views = 4;
  std::size_t samples = 8000;
  std::vector<std::string> folders;
};

bool parse(int count, char** words, Asked& asked) {
  for (int n = 1; n < count; ++n) {
    const std::string_view word = words[n];
    const auto number = [&] { return n + 1 < count ? std::strtoull(words[++n], nullptr, 10) : 0; };
    if (word == "--out" && n + 1 < count) {
      asked.out = words[++n];
    } else if (word == "--seed") {
      asked.seed = number();
    } else if (word == "--views") {
      asked.views = static_cast<int>(number());
    } else if (word == "--samples") {
      asked.samples = number();
    } else if (word == "--phantoms") {
      asked.first_phantom = number(), asked.last_phantom = number();
    } else if (word.starts_with("--")) {
      return false;
    } else {
      asked.folders.emplace_back(word);
    }
  }
  return !asked.out.empty();
}

struct Table {
  std::vector<std::int16_t> features;
  std::vector<std::uint8_t> parts;
  std::vector<std::int32_t> bodies;
};

// draws voxels of one view
void add(const suite::LabelledScan& scan, std::size_t samples, std::int32_t number, std::mt19937_64& random,
         Table& table) {
  // fine and coarse work grids, as users may have
  const Anatomy anatomy = anatomy_of(scan.grey, random() % 3 == 0 ? 3 : 4, 0);
  const CoarseBody body = coarse_body(anatomy);
  if (body.places.size() < 500) return;
  const VoxelFeatures features(body);
  const std::size_t width = voxel_feature_names().size();
  std::uniform_int_distribution<std::size_t> place(0, body.places.size() - 1);
  for (std::size_t n = 0; n < std::min(samples, body.places.size()); ++n) {
    const std::size_t o = body.places[place(random)];
    const Grid& g = body.grid();
    const auto at = static_cast<std::int64_t>(o);
    const Eigen::Vector3d index = scan.parts.grid.index(
        g.point(at % g.size[0], at / g.size[0] % g.size[1], at / (g.size[0] * g.size[1])));
    const auto i = nearest_whole(index[0]), j = nearest_whole(index[1]), k = nearest_whole(index[2]);
    if (!scan.parts.grid.holds(i, j, k) || !scan.parts.at(i, j, k)) continue;
    table.features.resize(table.features.size() + width);
    features.fill(o, std::span(table.features).last(width));
    table.parts.push_back(scan.parts.at(i, j, k));
    table.bodies.push_back(number);
  }
}

// NumPy's format, version 1.0
template <class T>
void write_npy(const std::string& path, const std::vector<T>& data, const char* type, std::size_t width) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}, {}), }}", type,
                                   data.size() / width, width);
  header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' ');
  header += '\n';
  std::ofstream file(path, std::ios::binary);
  const auto length = static_cast<std::uint16_t>(header.size());
  file << std::string_view("\x93NUMPY\x01\x00", 8) << static_cast<char>(length & 255)
       << static_cast<char>(length >> 8) << header;
  file.write(reinterpret_cast<const char*>(data.data()),
             static_cast<std::streamsize>(data.size() * sizeof(T)));
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

int run(const Asked& asked) {
  Table table;
  std::vector<std::string> names;
  const auto add_views = [&](const std::string& name, const suite::LabelledScan& whole) {
    const auto number = static_cast<std::int32_t>(names.size());
    std::mt19937_64 random(asked.seed * 1000003 + std::hash<std::string>()(name));
    names.push_back(name);
    add(whole, asked.samples, number, random, table);
    for (int view = 1; view < asked.views; ++view)
      add(suite::drawn_view(whole, random), asked.samples, number, random, table);
    fmt::print("{}: {} voxels so far\n", name, table.parts.size());
    std::fflush(stdout);
  };
  for (const std::string& folder : asked.folders) {
    const auto scan = suite::read_labelled(folder);
    if (!scan) throw std::runtime_error(scan.error().message());
    // the last two names, so that the bodies' location does not change the drawn voxels
    const std::filesystem::path path(folder);
    add_views((path.parent_path().filename() / path.filename()).string(), *scan);
  }
  for (std::uint64_t seed = asked.first_phantom; seed <= asked.last_phantom; ++seed)
    add_views(fmt::format("phantom {}", seed), suite::drawn_phantom(seed));
  write_npy(asked.out + "/features.npy", table.features, "<i2", voxel_feature_names().size());
  write_npy(asked.out + "/parts.npy", table.parts, "|u1", 1);
  write_npy(asked.out + "/bodies.npy", table.bodies, "<i4", 1);
  std::ofstream list(asked.out + "/names.txt");
  for (const std::string& name : voxel_feature_names()) list << name << ' ';
  list << '\n';
  for (const std::string& name : names) list << name << '\n';
  return list ? 0 : 1;
}

}  // namespace

int main(int count, char** words) {
  borelli::hold_freed_memory();
  Asked asked;
  if (!parse(count, words, asked)) {
    fmt::print(stderr,
               "forest_features --out FOLDER [--seed S] [--views V] [--samples N] [--phantoms FIRST LAST] "
               "[FOLDER ...]\n");
    return 2;
  }
  try {
    return run(asked);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
