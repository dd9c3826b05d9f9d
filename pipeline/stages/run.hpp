// The whole way from a volume to labels, inertia table, scene, motion, meshes, pictures and report, in one
// folder:
//
//   segmentation/  labels.nii.gz, labels.tsv, labels.ctbl, landmarks.json, landmarks.mrk.json, segmentation.json
//                  (and parts.nii.gz if segments are asked for)
//   inertia/       table.csv, table.json
//   model/         scene.toml
//   motion/        trajectory.h5, trajectory.csv
//   mesh/          *.stl, *.vtp
//   body.glb, body.png, report.html, run.json, settings.toml
//
// Each stage reads what the stages before it left, so that a run that was stopped goes on at the first
// unfinished one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/stages/stages.hpp"
#include "segmentation/files/quantity.hpp"

namespace borelli {

struct RunSettings {
  std::string volume;                    ///< file or DICOM folder
  std::filesystem::path folder;          ///< of this subject's results
  std::string subject;                   ///< its name in scene and report
  std::optional<FileQuantity> quantity;  ///< what the voxels hold, where the file does not say
  std::string labels;                    ///< a label map to use instead of segmenting; empty: segment
  std::string label_names;               ///< its names (TSV), where not beside it
  std::string label_mapping;  ///< from its classes to parts (class_mapping.hpp); empty: it holds parts
  std::string absent;         ///< parts that the body lacks (absent_parts.hpp); empty: none
  std::string landmarks;  ///< landmarks placed by hand (given_landmarks.hpp), which override what is found
  std::string sex;        ///< "male", "female", or empty: nothing to compare with
  std::string pose;       ///< "supine", "standing" ...: how the person lay or stood; empty: as DICOM says
  double stature_m = 0;   ///< sole to vertex; 0: not known
  std::string density_curve;              ///< empty: the default
  std::string convention = "deleva1996";  ///< of the cuts, see cuts.hpp; of given labels, how they were cut
  std::string frames = "joints";          ///< of the segments: "joints" or "isb"
  std::string method = "rk4_adaptive";    ///< integrator
  std::string equations = "recursive";    ///< of motion: "recursive" or "lagrange"
  std::string segments;                   ///< "trunk,thigh_left" (segments.hpp); empty: every part
  double work_grid_mm = 3;                ///< of the segmentation
  double table_tolerance = 0;             ///< share; the grid is picked by it (table_tolerance.hpp); 0: not
  /// Of the smallest model (economy.hpp) by which the body moves, and what of its motion is to stay within
  /// it (MotionQuantity; empty: all gravity centres). 0: the whole model moves.
  double model_tolerance = 0;
  std::vector<std::string> motion_quantities;
  double integrator_tolerance = 1e-6;  ///< where the integrator chooses its steps
  std::optional<double> step;          ///< fixed, or the first one tried, s; none: the scene's default
  double mesh_tolerance_mm = 1;
  bool keep_paths = false;         ///< outputs name inputs by whole paths, not by file names alone
  bool deface = false;             ///< meshes, picture and report show no face (deface.hpp)
  bool untrusted_is_fine = false;  ///< go on with a motion whose certificate says untrusted
  Leap leap;
  int threads = 0;
  std::string settings_text;  ///< what the user chose, kept as settings.toml; empty: none is kept
};

/// Runs what is not done yet and answers run.json. Without an X display there is no picture, which is a
/// warning. Errors before any work: inputs that are missing, a folder that cannot be written or in which
/// another run is at work.
Result<nlohmann::json> run(const RunSettings& settings, bool force, const StageObserver& observer = {});

}  // namespace borelli
