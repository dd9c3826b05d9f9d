// borelli segment VOLUME -o FOLDER: finds the parts of a body in a scan; writes a label map and landmarks.
#include <fmt/core.h>

#include <array>
#include <filesystem>
#include <optional>
#include <set>

#include "pipeline/body/belonging.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/dicom_segmentation.hpp"
#include "segmentation/labelling/body_doubts.hpp"
#include "segmentation/labelling/verdict.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct SegmentAsked {
  std::string volume, folder, quantity, landmarks, labels, names, mapping, segments, tolerance, absent,
      convention = "deleva1996";
  double step = 3;
  bool step_chosen = false, dicom = false, patient = false;
};

void print(const Segmentation& found, const std::string& reading, const std::string& folder) {
  fmt::print("{}\n", reading);
  const SegmentationVerdict verdict = verdict_of(found);
  fmt::print("segmentation: {}\n", name_of(verdict.verdict));
  for (const std::string& reason : verdict.reasons) fmt::print("  {}\n", reason);
  fmt::print("{:<18} {:<7} {:>10}  {}\n", "part", "in view", "litres", "confidence");
  // an MR without parts: lists its tissues
  std::array<std::size_t, 256> voxels{};
  for (const auto label : found.labels.voxels) ++voxels[label];
  for (std::size_t n = parts.size(); n < found.labels.names.size(); ++n)
    fmt::print("{:<18} {:<7} {:>10.3f}\n", found.labels.names[n], "",
               static_cast<double>(voxels[n]) * found.labels.grid.voxel_volume() * 1e-6);
  std::set<std::string, std::less<>> asked;
  for (const Segment& segment : found.asked) asked.insert(segment.of.begin(), segment.of.end());
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (!asked.empty() && !asked.contains(parts[n].name)) continue;
    const PartFinding& part = found.part[n];
    if (part.coverage == Coverage::absent)
      fmt::print("{:<18} {}\n", parts[n].name, part.note.empty() ? "absent" : part.note);
    else if (part.volume == 0)  // in view, but within another part's label
      fmt::print("{:<18} {:<7} {:>10}  {:<4}  {}\n", parts[n].name, name_of(part.coverage), "", "",
                 part.note);
    else
      fmt::print("{:<18} {:<7} {:>10.3f}  {:.2f}  {}\n", parts[n].name, name_of(part.coverage),
                 part.volume * 1e-6, part.confidence, part.note);
  }
  fmt::print(
      "wrote labels.nii.gz, landmarks.json and segmentation.json to {}; for 3D Slicer: labels.ctbl, "
      "landmarks.mrk.json\n",
      folder);
}

void warn_of_air(const GreyVolume& volume, const SegmentOptions& options, Segmentation& found) {
  if (!options.classes) return;
  add_warnings(found.warnings, WarningKind::labels, Severity::doubt,
               {doubt_of_classes(volume, *options.classes, options.threads)});
}

fs::path dicom_file(const SegmentAsked& asked) { return fs::path(asked.folder) / "labels.dcm"; }

// The headers of a DICOM scan for labels.dcm, after a check that it can be written. Nothing if it is not
// asked for, or the scan is not DICOM.
Result<std::optional<DicomSource>> dicom_source_of(const SegmentAsked& asked) {
  if (!asked.dicom) return std::nullopt;
  if (auto fine = check_writable(dicom_file(asked), {asked.volume, asked.labels}); !fine)
    return tl::unexpected(fine.error());
  std::error_code ignored;
  if (!fs::is_directory(asked.volume, ignored) && !is_dicom_file(asked.volume)) {
    if (asked.patient)
      return bad_use("--patient", "copies the patient's data from a DICOM scan, and " + asked.volume +
                                      " is not DICOM; leave it out");
    return std::nullopt;
  }
  auto source = read_dicom_source(asked.volume);
  if (!source) return tl::unexpected(source.error());
  return std::move(*source);
}

Result<void> write_dicom_file(const SegmentAsked& asked, const Segmentation& found,
                              const std::optional<DicomSource>& source) {
  if (!asked.dicom) return {};
  const LabelMap labels = found.asked.empty() ? found.labels : labels_of_segments(found.labels, found.asked);
  return write_dicom_label_file(dicom_file(asked), labels, source ? &*source : nullptr, asked.patient);
}

// `pick`: set if a tolerance picks the grid
Result<Segmentation> segment_scan(const GreyVolume& volume, const SegmentOptions& options,
                                  const SegmentChoice& segments, std::optional<GridPick>& pick) {
  if (pick && volume.quantity == Quantity::mr)
    return bad_use("--table-tolerance",
                   "does not apply to MR volumes, whose parts are found without a work grid; leave it out");
  if (pick) {
    MeasureOptions by;
    by.cuts = name_of(options.convention), by.threads = options.threads, by.segments = segments;
    return segment_within(volume, pick->tolerance, options, by, *pick);
  }
  if (volume.quantity != Quantity::mr) {
    auto found = segment(volume, options);
    if (found) warn_of_air(volume, options, *found);
    return found;
  }
  const auto reading = read_mr(volume, options.classes, options.threads);
  if (!reading) return tl::unexpected(reading.error());
  auto found = segment_mr(*reading, options);
  if (found) warn_of_air(reading->density, options, *found);
  return found;
}

Result<nlohmann::json> run(const SegmentAsked& asked, const Command& command) {
  auto segments = choose_segments(asked.segments);
  if (!segments) return tl::unexpected(segments.error());
  const auto absent = parse_absent(asked.absent);
  if (!absent) return tl::unexpected(absent.error());
  std::optional<GridPick> pick;
  if (!asked.tolerance.empty()) {
    if (asked.step_chosen)
      return bad_use("--table-tolerance",
                     "chooses the work grid itself; leave out --table-tolerance or --work-grid");
    const auto tolerance = parse_tolerance(asked.tolerance);
    if (!tolerance) return tl::unexpected(tolerance.error());
    pick.emplace().tolerance = *tolerance;
  }
  for (const std::string name : segmentation_file_names) {
    // (the user's own points stay: write_segmentation)
    const std::string points = name == "landmarks.mrk.json" ? "" : asked.landmarks;
    if (auto fine =
            check_writable(fs::path(asked.folder) / name, {asked.volume, asked.labels, asked.names, points});
        !fine)
      return tl::unexpected(fine.error());
  }
  const auto source = dicom_source_of(asked);
  if (!source) return tl::unexpected(source.error());
  ProgressBar bar(command.json);
  SegmentOptions options{asked.step, command.threads};
  options.convention = convention(asked.convention).value();
  options.absent = *absent;
  options.progress = [&](double share, std::string_view) { bar.update(share); };
  auto given = read_given_landmarks(command, asked.landmarks);
  if (!given) return tl::unexpected(given.error());
  const auto scanned = read_volume(command, asked.volume, asked.quantity);
  if (!scanned) return tl::unexpected(scanned.error());
  // in MR no landmarks are found, so all given points count, also unchanged ones
  options.given = scanned->volume.quantity == Quantity::mr ? given->all() : std::move(given->landmarks);
  std::optional<ClassLabels> classes;
  if (!asked.labels.empty()) {
    auto read = read_classes(command, asked.labels, asked.names, asked.mapping, scanned->volume);
    if (!read) return tl::unexpected(read.error());
    classes = std::move(*read);
    options.classes = &*classes;
  }
  bar.begin("finding the body's parts");
  auto found = segment_scan(scanned->volume, options, *segments, pick);
  bar.end(found ? "done" : "failed");
  if (!found) return tl::unexpected(found.error());
  found->asked = std::move(*segments);
  if (!asked.labels.empty())
    add_warnings(found->warnings, WarningKind::labels, Severity::doubt,
                 {doubt_of_frames(asked.volume, asked.labels)});
  add_reader_warnings(command.warnings(), scanned->volume.grid, *found);
  if (pick && !pick->met) found->warnings.push_back({WarningKind::table, Severity::note, in_words(*pick)});
  command.warn_first(in_sentences(found->warnings));
  const InputNames names = command.names();
  auto account =
      names.without_folders(segmentation_account(*found, names.name_of(asked.volume), scanned->reading));
  if (pick) account["tolerance"] = to_json(*pick);
  if (const auto written = write_segmentation(asked.folder, *found, account, asked.landmarks); !written)
    return tl::unexpected(written.error());
  if (const auto written = write_dicom_file(asked, *found, *source); !written)
    return tl::unexpected(written.error());
  if (!command.json) print(*found, scanned->reading, asked.folder);
  if (!command.json && pick && pick->met) fmt::print("{}\n", in_words(*pick));
  return account;
}

}  // namespace

void add_segment(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("segment", "Find the body parts and joint centres in a scan");
  auto asked = std::make_shared<SegmentAsked>();
  verb->add_option("volume", asked->volume, flags::volume.meaning)->required();
  add_output(*verb, asked->folder, "FOLDER", "Folder for the labels, landmarks and findings")->required();
  add_shared(*verb, flags::quantity, asked->quantity, flags::quantity_default);
  add_shared(*verb, flags::absent, asked->absent);
  add_shared(*verb, flags::landmarks, asked->landmarks, flags::landmarks_win);
  auto* labels = add_shared(
      *verb, flags::labels, asked->labels,
      "; it holds the classes of another program (see --label-mapping), which help to find the parts");
  auto* mapping = add_shared(*verb, flags::label_mapping, asked->mapping);
  labels->needs(mapping);
  mapping->needs(labels);
  add_shared(*verb, flags::label_names, asked->names)->needs(labels);
  add_shared(
      *verb, flags::convention, asked->convention,
      ": deleva1996 (de Leva's planes), dempster (Dempster's planes) or bone (each voxel with its bone)")
      ->check(one_of({"deleva1996", "dempster", "bone"}))
      ->capture_default_str();
  add_shared(*verb, flags::segments, asked->segments);
  add_shared(*verb, flags::work_grid, asked->step)->capture_default_str();
  add_shared(*verb, flags::table_tolerance, asked->tolerance,
             "; chooses the coarsest work grid that keeps it");
  add_shared(*verb, flags::keep_paths, command.keep_paths);
  auto* dicom = add_shared(*verb, flags::dicom, asked->dicom, "; it refers to the scan's images");
  add_shared(*verb, flags::patient, asked->patient)->needs(dicom);
  group_options(*verb, "Labels of another program", {"--labels", "--label-mapping", "--label-names"});
  group_options(*verb, "Parts", {"--convention", "--segments", "--work-grid", "--table-tolerance"});
  group_options(*verb, "Results", {"--keep-paths", "--dicom", "--patient"});
  verb->callback([&command, asked, verb] {
    asked->step_chosen = verb->count("--work-grid") > 0;
    command.work = [asked](const Command& chosen) { return run(*asked, chosen); };
  });
}

}  // namespace borelli
