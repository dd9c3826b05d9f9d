// Flags that several verbs have. Each is declared here once, so that it means the same everywhere.
// docs/flags.md lists all flags; tests/flags.py refuses a flag with two meanings.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <type_traits>

#include "dynamics/methods/integrator.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/files/input_names.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"

namespace borelli {

struct SharedFlag {
  const char* names;
  const char* value;  ///< name of a text value; nullptr: a number or no value
  const char* meaning;
  CLI::Validator (*check)() = nullptr;
};

/// Adds the flag to a verb. `detail`: what this verb adds to the meaning, "; ..." or " (default: ...)".
template <class T>
CLI::Option* add_shared(CLI::App& verb, const SharedFlag& flag, T& target, const std::string& detail = "") {
  const std::string meaning = flag.meaning + detail;
  if constexpr (std::is_same_v<T, bool>) {
    return verb.add_flag(flag.names, target, meaning);
  } else {
    CLI::Option* option = verb.add_option(flag.names, target, meaning);
    if (flag.value) option->type_name(flag.value);
    if (flag.check) option->check(flag.check());
    return option;
  }
}

/// Adds -o,--output. `value`: FILE or FOLDER.
template <class T>
CLI::Option* add_output(CLI::App& verb, T& target, const char* value, const std::string& meaning) {
  return add_shared(verb, {"-o,--output", value, meaning.c_str()}, target);
}

namespace flags {

// what a scan and its labels hold
inline constexpr SharedFlag volume{"--volume", "FILE",
                                   "CT, density or MR volume: a DICOM folder, .nii.gz, .nrrd or .mha"};
inline constexpr SharedFlag quantity{"--quantity", "NAME",
                                     "What the voxels hold: hu, density_kgm3, density_gcm3, labels or mr"};
inline constexpr const char* quantity_default = " (default: taken from the file)";
inline constexpr SharedFlag labels{"--labels", "FILE", "Label map of the body on the volume's grid"};
inline constexpr SharedFlag label_names{
    "--label-names", "FILE",
    "Names of the labels, a TSV file (default: the file of names beside the label map)"};
inline constexpr SharedFlag label_mapping{"--label-mapping", "NAME|FILE", label_mapping_help};
inline constexpr SharedFlag landmarks{
    "--landmarks", "FILE", "Joint centres and bony points: .json, or .mrk.json or .fcsv of 3D Slicer"};
inline constexpr const char* landmarks_win = "; they replace those that are found";
inline constexpr SharedFlag absent{"--absent", "PART,...", absent_help};
inline constexpr SharedFlag segments{"--segments", "PART,...", segments_help};
inline constexpr SharedFlag work_grid{"--work-grid", nullptr,
                                      "Spacing of the grid on which parts are found, mm",
                                      [] { return number_within(finest_step, coarsest_step); }};
inline constexpr SharedFlag table_tolerance{"--table-tolerance", "SHARE",
                                            "Largest error of every entry of the inertia table, e.g. 1%"};

// the person
inline constexpr SharedFlag subject{"--subject", "NAME", "Name of the subject"};
inline constexpr SharedFlag sex{"--sex", "SEX", "Sex of the body", [] { return one_of({"male", "female"}); }};
inline constexpr const char* sex_compares =
    "; shows published values of this sex for comparison (default: from DICOM)";
inline constexpr SharedFlag stature{"--stature", nullptr, "Body height from sole to vertex, m",
                                    [] { return number_within(0.3, 2.8); }};
inline constexpr SharedFlag mass{"--mass", nullptr, "Body mass, kg", positive_number};
inline constexpr SharedFlag pose{"--pose", "NAME",
                                 "How the person lay or stood, e.g. supine (default: from DICOM)"};

// the inertia table
inline constexpr SharedFlag density_curve{"--density-curve", "NAME",
                                          "Curve from CT numbers to densities, by name"};
inline constexpr SharedFlag convention{"--convention", "NAME", "How the body is cut into parts"};
inline constexpr SharedFlag frames{
    "--frames", "NAME",
    "Axes of the segments: joints (along the joint centres) or isb (as the ISB defines them)", [] {
      return one_of({"joints", "isb"});
    }};

// integration
inline constexpr SharedFlag accuracy{
    "--accuracy", nullptr,
    "Largest error of positions and velocities, relative to their scales; chooses the integrator and its "
    "tolerance",
    [] { return number_within(1e-11, 0.1); }};
inline constexpr SharedFlag method{"--method", "METHOD", "Integrator",
                                   [] { return one_of(integrator_names()); }};
inline constexpr SharedFlag equations{
    "--equations", "NAME", "Equations of motion: recursive (along the tree) or lagrange (the paper's scan)",
    [] {
      return one_of({"recursive", "lagrange"});
    }};
inline constexpr SharedFlag constraints{
    "--constraints", "NAME",
    "Treatment of constraint drift: projection, or baumgarte (restoring accelerations)", [] {
      return one_of({"projection", "baumgarte"});
    }};
inline constexpr SharedFlag tolerance{"--tolerance", nullptr,
                                      "Largest error per step of an adaptive integrator", positive_number};
inline constexpr SharedFlag step{"--step", nullptr, "Fixed step, or first step of an adaptive integrator, s",
                                 positive_number};
inline constexpr SharedFlag end{"--end", nullptr, "End time of the simulation, s (default: the scene's)",
                                positive_number};
inline constexpr SharedFlag methods{"--methods", "METHOD", "Integrators, separated by commas"};
inline constexpr SharedFlag samples{"--samples", nullptr, "Number of times at which motions are compared",
                                    [] { return whole_number_within(1, 100000); }};
inline constexpr SharedFlag allow_untrusted{"--allow-untrusted", nullptr,
                                            "Accept a motion that its certificate does not trust"};
inline constexpr SharedFlag model_tolerance{
    "--model-tolerance", "SHARE",
    "Largest error of the motion, e.g. 5%; chooses the smallest model that stays within it. Lengths are "
    "relative to the scene's size, angles in rad"};
inline constexpr SharedFlag keep{
    "--keep", "QUANTITY",
    "What of the motion must stay within --model-tolerance: centre, solid:NAME, solid:NAME:x,y,z, turn:NAME "
    "or coordinate:NAME; may be repeated (default: the gravity centres of all solids)"};

// recorded motion
inline constexpr SharedFlag motion{"--motion", "FILE", "Recorded motion"};
inline constexpr SharedFlag forces{
    "--forces", "FILE", "Measured ground forces: .mot, .sto, .c3d or OpenSim's external loads (.xml)"};
inline constexpr SharedFlag standing{"--static", "FILE",
                                     "Recording of the person standing still: .trc, .c3d or .bvh"};
inline constexpr SharedFlag setup{"--setup", "FILE", "OpenSim's set-up (.xml)"};
inline constexpr SharedFlag from{"--from", nullptr, "First time of the recording to use, s", finite_number};
inline constexpr SharedFlag to{"--to", nullptr, "Last time of the recording to use, s", finite_number};
inline constexpr SharedFlag bvh_unit{"--bvh-unit", nullptr,
                                     "Length of a BVH file's unit, m (default: guessed from the "
                                     "skeleton's size)",
                                     positive_number};
inline constexpr SharedFlag cut_off{"--cut-off", nullptr,
                                    "Cut-off of the low-pass filter over the joint angles, Hz; 0: none",
                                    number_not_negative};

// outputs
inline constexpr SharedFlag mesh_tolerance{"--mesh-tolerance-mm", nullptr,
                                           "How far mesh simplification may move the surface, mm",
                                           [] { return number_within(0, 50); }};
inline constexpr SharedFlag deface{"--deface", nullptr, "Remove the face from meshes, picture and report"};
inline constexpr SharedFlag keep_paths{"--keep-paths", nullptr, keep_paths_help};
inline constexpr SharedFlag dicom{"--dicom", nullptr, "Write the labels as a DICOM segmentation, labels.dcm"};
inline constexpr SharedFlag patient{"--patient", nullptr, patient_help};

}  // namespace flags

}  // namespace borelli
