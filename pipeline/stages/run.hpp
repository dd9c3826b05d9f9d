// Runs everything from a volume to labels, inertia table, scene, motion, meshes, pictures and report, in one
// folder:
//
//   segmentation/  labels.nii.gz, labels.tsv, labels.ctbl, landmarks.json, landmarks.mrk.json,
//                  segmentation.json (and parts.nii.gz if segments are requested)
//   inertia/       table.csv, table.json
//   model/         scene.toml, and for other programs body.osim and body.xml (MJCF)
//   motion/        trajectory.h5, trajectory.csv
//                  (of a captured motion also angles.mot, moments.sto, powers.sto, marker_errors.sto,
//                  efforts.json, and model/captured.toml)
//   mesh/          *.stl, *.vtp
//   body.glb (and skin.glb if asked for), body.png, report.html, run.json, settings.toml
//
// Each stage reads the files of earlier stages, so an interrupted run continues at the first unfinished
// stage.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/stages/stages.hpp"
#include "pipeline/video/video.hpp"
#include "segmentation/files/quantity.hpp"

namespace borelli {

/// A captured motion for the body (pipeline/motion/captured_motion.hpp), instead of the leap.
struct CapturedSettings {
  /// markers (.trc, .c3d), a skeleton (.bvh) or joint angles (.mot, .sto); empty: the body leaps
  std::string motion;
  std::string forces;  ///< ground forces (.mot, .sto, .xml, .c3d); empty: those of a C3D motion
  std::string trial;   ///< the person standing still; empty: a frame of the motion
  std::string
      marker_map;  ///< from markers to landmarks or segments (joint_mapping.hpp); empty: by their names
  bool other_person = false;  ///< the recorded person is not the scanned one
  bool calibrate = false;     ///< finds the markers' positions from the motion (marker_calibration.hpp)
  double recorded_mass = 0;   ///< kg, of the other person; 0: from the forces
  double cutoff = 6;          ///< Hz, of the low-pass filter over the joint angles; 0: none
  int band_draws = 24;        ///< for each cause of error (effort_bands.hpp); 0: no error bands
  double bvh_unit = 0;        ///< metres of a BVH file's unit; 0: guessed
};

struct RunSettings {
  std::string volume;                    ///< file or DICOM folder
  std::filesystem::path folder;          ///< folder of this subject's results
  std::string subject;                   ///< its name in scene and report
  std::optional<FileQuantity> quantity;  ///< what the voxels hold, if the file does not say
  std::string labels;                    ///< a label map to use instead of segmenting; empty: segment
  std::string label_names;               ///< its names (TSV), if not beside it
  std::string label_mapping;  ///< from its classes to parts (class_mapping.hpp); empty: it holds parts
  std::string absent;         ///< parts that the body lacks (absent_parts.hpp); empty: none
  std::string landmarks;  ///< landmarks placed by hand (given_landmarks.hpp), which override what is found
  std::string sex;        ///< "male", "female", or empty: no comparison with published values
  std::string pose;       ///< "supine", "standing" ...: how the person lay or stood; empty: as DICOM says
  double stature_m = 0;   ///< sole to vertex; 0: not known
  std::string density_curve;              ///< empty: the default
  std::string convention = "deleva1996";  ///< of the cuts, see cuts.hpp; given labels: how they were cut
  std::string frames = "joints";          ///< of the segments: "joints" or "isb"
  double accuracy = 1e-6;                 ///< of the motion (SimulationSettings), if no method is named
  std::string method;                     ///< integrator; empty: chosen from the accuracy
  std::string equations = "recursive";    ///< of motion: "recursive" or "lagrange"
  std::string segments;                   ///< "trunk,thigh_left" (segments.hpp); empty: every part
  double work_grid_mm = 3;                ///< of the segmentation
  double table_tolerance = 0;             ///< a share; selects the grid (table_tolerance.hpp); 0: off
  /// Tolerance of the smallest model (economy.hpp) that replaces the body in motion, and the quantities that
  /// must stay within it (MotionQuantity; empty: all gravity centres). 0: the whole model moves.
  double model_tolerance = 0;
  std::vector<std::string> motion_quantities;
  double integrator_tolerance = 1e-6;  ///< of a named method that chooses its steps
  std::optional<double> step;          ///< s, of a named method, fixed or first; empty: the scene's default
  double mesh_tolerance_mm = 1;
  bool keep_paths = false;  ///< outputs name inputs by whole paths, not by file names alone
  bool skin = false;        ///< also write skin.glb, one closed skin (skin.hpp)
  std::string video;        ///< a file in the run's folder (.mp4): also film the motion; empty: no
  VideoOptions video_options;
  bool deface = false;             ///< meshes, picture and report without the face (deface.hpp)
  bool untrusted_is_fine = false;  ///< continue with a motion whose certificate says untrusted
  Leap leap;
  CapturedSettings captured;
  int threads = 0;
  std::string settings_text;  ///< the user's settings, saved as settings.toml; empty: not saved
};

/// Runs the stages that are not done yet and returns run.json. A machine that cannot draw (render.hpp) makes
/// no picture, only a warning. Errors before any work: missing inputs, a folder that cannot be written or is
/// locked by another run.
Result<nlohmann::json> run(const RunSettings& settings, bool force, const StageObserver& observer = {});

}  // namespace borelli
