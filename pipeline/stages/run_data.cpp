#include "pipeline/stages/run_data.hpp"

#include "dynamics/formats/scene_file.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/body/given_labels.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/export/mesh_file.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "segmentation/files/landmarks_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

// Reads a segmentation back from its files.
Result<Segmentation> read_back(const fs::path& folder, const std::string& segments) {
  Segmentation found;
  auto labels = read_labels((folder / (segments.empty() ? "labels.nii.gz" : "parts.nii.gz")).string());
  if (!labels) return tl::unexpected(labels.error());
  auto asked = choose_segments(segments, labels->names);
  if (!asked) return tl::unexpected(asked.error());
  auto landmarks = read_landmarks((folder / "landmarks.json").string());
  if (!landmarks) return tl::unexpected(landmarks.error());
  auto findings = read_findings(folder / "segmentation.json");
  if (!findings) return tl::unexpected(findings.error());
  found.labels = std::move(*labels);
  found.landmarks = std::move(*landmarks);
  found.part = *findings;
  auto warnings = read_warnings(folder / "segmentation.json");
  if (!warnings) return tl::unexpected(warnings.error());
  found.warnings = std::move(*warnings);
  found.asked = std::move(*asked);
  const auto absent = read_absent(folder / "segmentation.json");
  if (!absent) return tl::unexpected(absent.error());
  found.absent = *absent;
  return found;
}

}  // namespace

template <class T, class Make>
Result<const T*> RunData::once(std::optional<T>& stored, Make make) {
  const std::lock_guard lock(mutex_);
  if (!stored) {
    auto made = make();
    if (!made) return tl::unexpected(made.error());
    stored = std::move(*made);
  }
  return &*stored;
}

void RunData::add_reader_warnings(const std::vector<std::string>& warnings) {
  const std::lock_guard lock(mutex_);
  for (const std::string& warning : warnings) reader_warnings_.push_back(names.without_folders(warning));
}

std::vector<std::string> RunData::reader_warnings() {
  const std::lock_guard lock(mutex_);
  return reader_warnings_;
}

Result<const ScannedVolume*> RunData::scan(const Progress& progress) {
  return once(scan_, [&]() -> Result<ScannedVolume> {
    auto read = read_volume(settings.volume, {settings.quantity, progress});
    if (read) add_reader_warnings(read->warnings);
    if (read && !settings.density_curve.empty() && read->volume.quantity != Quantity::hu)
      return bad_use("--density-curve",
                     "applies to CT numbers, and " + settings.volume + " contains none; leave it out");
    return read;
  });
}

Result<const ClassLabels*> RunData::classes() {
  if (settings.label_mapping.empty()) return nullptr;
  return once(classes_, [&] {
    const auto scanned = scan();
    if (!scanned) return Result<ClassLabels>(tl::unexpected(scanned.error()));
    auto read =
        read_classes(settings.labels, settings.label_names, settings.label_mapping, &(*scanned)->volume);
    if (read) add_reader_warnings(read->warnings);
    return read;
  });
}

Result<const MrReading*> RunData::mr() {
  return once(mr_, [&]() -> Result<MrReading> {
    const auto scanned = scan();
    if (!scanned) return tl::unexpected(scanned.error());
    const auto given = classes();
    if (!given) return tl::unexpected(given.error());
    return read_mr((*scanned)->volume, *given, settings.threads);
  });
}

Result<const GreyVolume*> RunData::weighed() {
  const auto scanned = scan();
  if (!scanned) return tl::unexpected(scanned.error());
  if ((*scanned)->volume.quantity != Quantity::mr) return &(*scanned)->volume;
  const auto reading = mr();
  if (!reading) return tl::unexpected(reading.error());
  return &(*reading)->density;
}

Result<const Segmentation*> RunData::segmentation() {
  return once(segmentation_, [&] { return read_back(file("segmentation"), settings.segments); });
}

Result<const LabelMap*> RunData::labels() {
  const auto found = segmentation();
  if (!found) return tl::unexpected(found.error());
  if ((*found)->asked.empty()) return &(*found)->labels;
  return once(labels_,
              [&]() -> Result<LabelMap> { return labels_of_segments((*found)->labels, (*found)->asked); });
}

Result<const InertiaTable*> RunData::table() {
  return once(table_, [&] { return read_table(file("inertia/table.json")); });
}

Result<const Scene*> RunData::scene() {
  return once(scene_, [&] { return read_scene(file("model/scene.toml")); });
}

Result<const Scene*> RunData::moving() {
  if (settings.model_tolerance == 0) return scene();
  return once(smallest_, [&] { return read_scene(file("model/smallest.toml")); });
}

Result<const Trajectory*> RunData::trajectory() {
  return once(trajectory_, [&]() -> Result<Trajectory> {
    auto stored = read_trajectory(file("motion/trajectory.h5"));
    if (!stored) return tl::unexpected(stored.error());
    return std::move(stored->trajectory);
  });
}

Result<const std::vector<Mesh>*> RunData::meshes() {
  return once(meshes_, [&]() -> Result<std::vector<Mesh>> {
    std::vector<Mesh> stored;
    const auto asked = labels();
    if (!asked) return tl::unexpected(asked.error());
    for (const std::string& name : (*asked)->names) {
      const fs::path path = file("mesh/" + name + ".vtp");
      if (std::error_code problem; !fs::exists(path, problem)) continue;  // a part without voxels
      auto mesh = read_vtp(path.string());
      if (!mesh) return tl::unexpected(mesh.error());
      stored.push_back(std::move(*mesh));
    }
    return stored;
  });
}

Result<const ScanPoses*> RunData::poses() {
  return once(poses_, [&]() -> Result<ScanPoses> {
    const auto of_parts = table();
    if (!of_parts) return tl::unexpected(of_parts.error());
    const auto found = segmentation();
    if (!found) return tl::unexpected(found.error());
    std::vector<Warning> said_by_the_scene;
    return scan_poses(movable_parts(**of_parts, said_by_the_scene), (*found)->landmarks);
  });
}

Result<const Skin*> RunData::skin() {
  return once(skin_, [&]() -> Result<Skin> {
    const auto asked = labels();
    if (!asked) return tl::unexpected(asked.error());
    const auto X_WS = poses();
    if (!X_WS) return tl::unexpected(X_WS.error());
    const auto found = segmentation();
    if (!found) return tl::unexpected(found.error());
    SkinOptions options;
    options.tolerance = 1e-3 * settings.mesh_tolerance_mm;
    options.threads = settings.threads;
    return skin_of(**asked, skin_joints(**asked, (*found)->landmarks), **X_WS, options);
  });
}

}  // namespace borelli
