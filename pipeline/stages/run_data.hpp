// What the stages of a run hand on to each other.
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
#include "pipeline/export/mesh.hpp"
#include "pipeline/files/input_names.hpp"
#include "pipeline/report/report.hpp"
#include "pipeline/stages/run.hpp"
#include "pipeline/stages/run_inputs.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Each thing is read from its file when a stage asks for it and no stage before it in this run made it.
/// Errors: those of reading. Stages may ask and keep side by side; what one of them keeps is asked for by
/// those alone that need it.
class RunData {
 public:
  explicit RunData(const RunSettings& of_run) : settings(of_run), names(input_names(of_run)) {}

  Result<const ScannedVolume*> scan(const Progress& progress = {});
  /// The classes of somebody else's label map; nothing where none is given.
  Result<const ClassLabels*> classes();
  /// The reading of an MR scan.
  Result<const MrReading*> mr();
  /// What masses are taken from: the scan, or the densities read off an MR.
  Result<const GreyVolume*> weighed();
  Result<const Segmentation*> segmentation();
  /// The labels of the segments that are asked for.
  Result<const LabelMap*> labels();
  Result<const InertiaTable*> table();
  Result<const Scene*> scene();
  /// What moves: the scene, or the smallest model of it where that is asked for.
  Result<const Scene*> moving();
  Result<const Trajectory*> trajectory();
  Result<const std::vector<Mesh>*> meshes();
  /// What the report shows of the scan; null where no stage of this run made it.
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

  /// Warnings of the inputs' readers so far. A run that fails needs them: no stage has recorded them yet.
  void add_reader_warnings(const std::vector<std::string>& warnings);
  std::vector<std::string> reader_warnings();

  /// Where a file of the run's folder is.
  std::filesystem::path file(const std::string& name) const { return settings.folder / name; }

  const RunSettings& settings;
  const InputNames names;

 private:
  template <class T, class Make>
  Result<const T*> once(std::optional<T>& held, Make make);
  template <class T>
  void put(std::optional<T>& held, T made) {
    const std::lock_guard lock(mutex_);
    held = std::move(made);
  }

  std::recursive_mutex mutex_;  // of all that follows: one thing is made from another
  std::optional<ScannedVolume> scan_;
  std::optional<ClassLabels> classes_;
  std::optional<MrReading> mr_;
  std::optional<Segmentation> segmentation_;
  std::optional<LabelMap> labels_;
  std::optional<InertiaTable> table_;
  std::optional<Scene> scene_, smallest_;
  std::optional<Trajectory> trajectory_;
  std::optional<std::vector<Mesh>> meshes_;
  std::optional<ScanViews> views_;
  std::vector<std::string> reader_warnings_;
};

}  // namespace borelli
