// warped_bodies: writes warped bodies and their truth.
//   warped_bodies [--seeds FIRST LAST | --rest] [--body am|af|both] [--open-sealed] [--whole] --out FOLDER
// Odd seeds are the sealed half, kept unseen for the final score: they are omitted unless --open-sealed is
// given. --whole: the whole body on 3 mm voxels without effects, to inspect its shape and pose. Each goes to
// FOLDER/NNN (with both bodies FOLDER/am/NNN ...; at rest FOLDER/am, FOLDER/af): scan.nii.gz, parts.nii.gz,
// bones.nii.gz, truth.json.
#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "segmentation/files/write.hpp"
#include "segmentation/volume/held_memory.hpp"
#include "tests/paths.hpp"
#include "tests/suite/warped_bodies.hpp"

namespace {

using namespace borelli;

nlohmann::json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json inertial_json(const Inertial& i) {
  nlohmann::json tensor = nlohmann::json::array();
  for (int row = 0; row < 3; ++row) tensor.push_back(vector_json(i.tensor.row(row).transpose()));
  return {{"mass_kg", i.mass}, {"centre_m", vector_json(i.centre)}, {"tensor_kgm2", tensor}};
}

nlohmann::json truth_json(const suite::TrueScan& scan) {
  nlohmann::json out{{"what", scan.what}, {"kinds", scan.kinds}, {"overlap_ml", scan.overlap / 1000}};
  for (const auto& [name, landmark] : scan.landmarks)
    out["landmarks"][name] = {{"point_mm", vector_json(landmark.point)},
                              {"deviation_mm", landmark.deviation},
                              {"radius_mm", landmark.radius}};
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const suite::PartTruth& part = scan.part[n];
    out["parts"][std::string(parts[n].name)] = {{"coverage", name_of(part.coverage)},
                                                {"stump", part.stump},
                                                {"share_in_scan", part.share},
                                                {"whole", inertial_json(part.whole)},
                                                {"in_scan", inertial_json(part.seen)}};
  }
  return out;
}

Result<void> write(const suite::TrueScan& scan, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return failure(folder.string(), error.message());
  if (auto done = write_volume((folder / "scan.nii.gz").string(), scan.grey); !done) return done;
  if (auto done = write_labels((folder / "parts.nii.gz").string(), scan.labels); !done) return done;
  if (auto done = write_labels((folder / "bones.nii.gz").string(), scan.bones); !done) return done;
  std::ofstream file(folder / "truth.json");
  file << truth_json(scan).dump(1) << "\n";
  if (!file.flush()) return failure((folder / "truth.json").string(), "cannot be written");
  return {};
}

struct Asked {
  std::uint64_t first = 0, last = 0;
  bool rest = false, open_sealed = false, whole = false;
  std::vector<std::string> bodies{"am", "af"};
  std::string out;
};

bool parse(int count, char** words, Asked& asked) {
  bool seeds = false;
  for (int n = 1; n < count; ++n) {
    if (!std::strcmp(words[n], "--seeds") && n + 2 < count) {
      asked.first = std::strtoull(words[n + 1], nullptr, 10),
      asked.last = std::strtoull(words[n + 2], nullptr, 10);
      n += 2, seeds = true;
    } else if (!std::strcmp(words[n], "--rest")) {
      asked.rest = true;
    } else if (!std::strcmp(words[n], "--open-sealed")) {
      asked.open_sealed = true;
    } else if (!std::strcmp(words[n], "--whole")) {
      asked.whole = true;
    } else if (!std::strcmp(words[n], "--out") && n + 1 < count) {
      asked.out = words[++n];
    } else if (!std::strcmp(words[n], "--body") && n + 1 < count) {
      const std::string body = words[++n];
      if (body != "am" && body != "af" && body != "both") return false;
      if (body != "both") asked.bodies = {body};
    } else {
      return false;
    }
  }
  return seeds != asked.rest && !asked.out.empty();
}

}  // namespace

int main(int count, char** words) {
  borelli::hold_freed_memory();
  Asked asked;
  if (!parse(count, words, asked)) {
    fmt::print(stderr,
               "warped_bodies [--seeds FIRST LAST | --rest] [--body am|af|both] [--open-sealed] [--whole] "
               "--out FOLDER\n");
    return 2;
  }
  for (const std::string& name : asked.bodies) {
    const auto body = suite::read_labelled_body(name, test::shared_folder());
    if (!body) {
      fmt::print(stderr, "{}\n", body.error().message());
      return 1;
    }
    fmt::print(stderr, "{}: {:.3f} kg\n", name, body->mass);
    for (std::uint64_t seed = asked.first; seed <= asked.last; ++seed) {
      if (seed % 2 && !asked.open_sealed) continue;
      const auto begin = std::chrono::steady_clock::now();
      suite::Warp warp = asked.rest ? suite::rest_warp() : suite::fitting_warp(*body, seed);
      if (asked.whole) warp.scanner = suite::rest_warp().scanner;
      const suite::WarpedBody made = suite::warped_body(*body, warp);
      std::filesystem::path folder = asked.out;
      if (asked.rest || asked.bodies.size() > 1) folder /= name;
      if (!asked.rest) folder /= fmt::format("{:03}", seed);
      if (const auto done = write(made, folder); !done) {
        fmt::print(stderr, "{}\n", done.error().message());
        return 1;
      }
      fmt::print(stderr, "{} (overlap {:.0f} ml, {:.1f} s)\n", made.what, made.overlap / 1000,
                 std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
  }
  return 0;
}
