// Data that the stages of a run share.
#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/run/simulate.hpp"
#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"
#include "inertia/table.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/export/mesh.hpp"
#include "pipeline/export/skin.hpp"
#include "pipeline/files/input_names.hpp"
#include "pipeline/report/report.hpp"
#include "pipeline/stages/run.hpp"
#include "pipeline/stages/run_inputs.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Each item is read from its file when a stage asks for it, unless an earlier stage of this run made it.
/// Errors: those of reading. Stages may ask and keep concurrently; only stages that depend on an item's
/// producer ask for that item.
class RunData {
 public:
  explicit RunData(const RunSettings& of_run) : settings(of_run), names(input_names(of_run)) {}

  Result<const ScannedVolume*> scan(const Progress& progress = {});
  /// Classes of another program's label map; null if none is given.
  Result<const ClassLabels*> classes();
  /// The reading of an MR scan.
  Result<const MrReading*> mr();
  /// Source of the masses: the scan, or the densities read off an MR.
  Result<const GreyVolume*> weighed();
  Result<const Segmentation*> segmentation();
  /// Labels of the requested segments.
  Result<const LabelMap*> labels();
  Result<const InertiaTable*> table();
  Result<const Scene*> scene();
  /// The scene to simulate: the whole one, or its smallest model if that was requested.
  Result<const Scene*> moving();
  Result<const Trajectory*> trajectory();
  Result<const std::vector<Mesh>*> meshes();
  /// The frames of the parts that move, in the scan's pose.
  Result<const ScanPoses*> poses();
  /// The body's closed skin (skin_of).
  Result<const Skin*> skin();
  /// The report's views of the scan; null if no stage of this run made them.
  const ScanViews* views() {
    const std::lock_guard lock(mutex_);
    return views_ ? &*views_ : nullptr;
  }

  void keep(Segmentation made) { put(segmentation_, std::move(made)); }
  void keep(InertiaTable made) { put(table_, std::move(made)); }
  void keep(Scene made) { put(scene_, std::move(made)); }
  void keep_smallest(Scene made) { put(smallest_, std::move(made)); }
  void keep(Trajectory made) { put(trajectory_, std::move(made)); }
  void keep(std::vector<Mesh> made) { put(meshes_, std::move(made)); }
  void keep(ScanViews made) { put(views_, std::move(made)); }

  /// Warnings of the inputs' readers so far, without folders. A failed run needs them, since no stage has
  /// recorded them yet.
  void add_reader_warnings(const std::vector<std::string>& warnings);
  std::vector<std::string> reader_warnings();

  /// Path of a file in the run's folder.
  std::filesystem::path file(const std::string& name) const { return settings.folder / name; }

  const RunSettings& settings;
  const InputNames names;

 private:
  /// Returns `stored`; fills it by make() at the first call. Errors: those of make(), which the next call repeats.
  template <class T, class Make>
  Result<const T*> once(std::optional<T>& stored, Make make);
  template <class T>
  void put(std::optional<T>& stored, T made) {
    const std::lock_guard lock(mutex_);
    stored = std::move(made);
  }

  std::recursive_mutex mutex_;  // guards all members below; recursive, since one item is made from another
  std::optional<ScannedVolume> scan_;
  std::optional<ClassLabels> classes_;
  std::optional<MrReading> mr_;
  std::optional<Segmentation> segmentation_;
  std::optional<LabelMap> labels_;
  std::optional<InertiaTable> table_;
  std::optional<Scene> scene_, smallest_;
  std::optional<Trajectory> trajectory_;
  std::optional<std::vector<Mesh>> meshes_;
  std::optional<ScanPoses> poses_;
  std::optional<Skin> skin_;
  std::optional<ScanViews> views_;
  std::vector<std::string> reader_warnings_;
};

}  // namespace borelli
