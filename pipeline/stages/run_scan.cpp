#include "pipeline/stages/run_scan.hpp"

#include <algorithm>
#include <optional>

#include "inertia/table_file.hpp"
#include "pipeline/body/belonging.hpp"
#include "pipeline/body/given_labels.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/files/subject.hpp"
#include "pipeline/files/whole_file.hpp"
#include "segmentation/files/dicom_segmentation.hpp"
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/labelling/body_doubts.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Warnings = std::vector<std::string>;

Result<json> hand_on(RunData& data, Segmentation& found, const ScannedVolume& scan,
                     const std::optional<GridPick>& pick = {}) {
  auto asked = choose_segments(data.settings.segments, found.labels.names);
  if (!asked) return tl::unexpected(asked.error());
  found.asked = std::move(*asked);
  json account = data.names.without_folders(
      segmentation_account(found, data.names.name_of(data.settings.volume), scan.reading));
  account["convention"] = data.settings.convention;
  if (pick) account["tolerance"] = to_json(*pick);
  if (auto written = write_segmentation(data.file("segmentation"), found, account, data.settings.landmarks);
      !written)
    return tl::unexpected(written.error());
  json parts_found = json::object();
  for (const auto& [name, part] : account["parts"].items()) parts_found[name] = part["coverage"];
  json answer{{"warnings", account["warnings"]},
              {"single_warnings", account["single_warnings"]},
              {"verdict", account["verdict"]},
              {"verdict_reasons", account["verdict_reasons"]},
              {"reading", scan.reading},
              {"format", scan.format},
              {"parts", parts_found}};
  if (pick) answer["tolerance"] = account["tolerance"];
  return answer;
}

MeasureOptions measuring(const RunSettings& settings, const ScannedVolume& scan) {
  MeasureOptions options;
  options.density_curve = settings.density_curve;
  options.sex = subject_of(scan, settings.sex).sex;
  options.pose = settings.pose.empty() ? scan.pose : settings.pose;
  options.stature_m = settings.stature_m;
  options.cuts = settings.convention;
  options.frames = settings.frames;
  options.threads = settings.threads;
  return options;
}

Result<Segmentation> part_scan(RunData& data, const GreyVolume& volume, const SegmentOptions& options,
                               std::optional<GridPick>& pick) {
  if (data.settings.table_tolerance > 0 && volume.quantity != Quantity::mr) {
    // without options that the segmentation does not depend on
    MeasureOptions by;
    by.cuts = data.settings.convention, by.threads = data.settings.threads;
    auto asked = choose_segments(data.settings.segments);
    if (!asked) return tl::unexpected(asked.error());
    by.segments = std::move(*asked);
    auto found = segment_within(volume, data.settings.table_tolerance, options, by, pick.emplace());
    if (found && !pick->met) found->warnings.push_back({WarningKind::table, Severity::note, in_words(*pick)});
    return found;
  }
  if (volume.quantity != Quantity::mr) return segment(volume, options);
  if (data.settings.table_tolerance > 0 && data.settings.model_tolerance == 0)
    return bad_use("--table-tolerance",
                   "does not apply to MR volumes, whose parts are found without a work grid; leave it out");
  const auto reading = data.mr();
  if (!reading) return tl::unexpected(reading.error());
  return segment_mr(**reading, options);
}

}  // namespace

Result<json> segment_scan(RunData& data, const StageProgress& progress) {
  const auto scan = data.scan([&](double share) { progress(0.2 * share); });
  if (!scan) return tl::unexpected(scan.error());
  SegmentOptions options{data.settings.work_grid_mm, data.settings.threads};
  const auto cuts = convention(data.settings.convention);
  if (!cuts) return tl::unexpected(cuts.error());
  options.convention = *cuts;
  const auto absent = parse_absent(data.settings.absent);
  if (!absent) return tl::unexpected(absent.error());
  options.absent = *absent;
  options.progress = [&](double share, std::string_view) { progress(0.2 + 0.7 * share); };
  const auto classes = data.classes();
  if (!classes) return tl::unexpected(classes.error());
  options.classes = *classes;
  Warnings of_landmarks, of_labels;
  if (!data.settings.landmarks.empty()) {
    auto given = read_given_landmarks(data.settings.landmarks);
    if (!given) return tl::unexpected(given.error());
    // in MR no landmarks are found, so all given points count, also unchanged ones
    options.given = (*scan)->volume.quantity == Quantity::mr ? given->all() : std::move(given->landmarks);
    data.add_reader_warnings(given->warnings);
    of_landmarks = std::move(given->warnings);
  }
  if (const auto doubt = doubt_of_frames(data.settings.volume, data.settings.labels); !doubt.empty())
    of_labels.push_back(doubt);
  std::optional<GridPick> pick;
  auto found = part_scan(data, (*scan)->volume, options, pick);
  if (!found) return tl::unexpected(found.error());
  if (options.classes) {
    const auto weighed = data.weighed();
    if (!weighed) return tl::unexpected(weighed.error());
    if (auto said = doubt_of_classes(**weighed, *options.classes, options.threads); !said.empty())
      of_labels.push_back(std::move(said));
  }
  add_reader_warnings((*scan)->warnings, (*scan)->volume.grid, *found);
  add_warnings(found->warnings, WarningKind::landmark, Severity::note, of_landmarks);
  add_warnings(found->warnings, WarningKind::labels, Severity::doubt, of_labels);
  auto answer = hand_on(data, *found, **scan, pick);
  data.keep(std::move(*found));
  return answer;
}

Result<json> use_given_labels(RunData& data, const StageProgress& progress) {
  const auto scan = data.scan([&](double share) { progress(0.5 * share); });
  if (!scan) return tl::unexpected(scan.error());
  auto labels = read_labels(data.settings.labels, data.settings.label_names, {}, &(*scan)->volume.grid);
  if (!labels) return tl::unexpected(labels.error());
  if (std::ranges::none_of(labels->names, [](const std::string& name) { return part_label(name) > 0; }))
    return bad_use(
        data.settings.labels,
        "names none of the body's parts; put a names file beside it (.tsv with lines of label, tab and "
        "name, as segment writes it), or map its classes with --label-mapping");
  Warnings label_warnings;
  for (const std::string& warning : labels->warnings)
    label_warnings.push_back(data.settings.labels + ": " + warning);
  data.add_reader_warnings(label_warnings);
  const std::string sides = compare_sides(*labels);
  GivenLandmarks given;
  if (!data.settings.landmarks.empty()) {
    auto read = read_given_landmarks(data.settings.landmarks);
    if (!read) return tl::unexpected(read.error());
    given = std::move(*read);
    data.add_reader_warnings(given.warnings);
  }
  Landmarks landmarks;
  put_given(given.all(), landmarks);
  const auto weighed = data.weighed();
  if (!weighed) return tl::unexpected(weighed.error());
  Segmentation found =
      segmentation_of(std::move(*labels), std::move(landmarks), **weighed, data.settings.threads);
  add_reader_warnings((*scan)->warnings, (*scan)->volume.grid, found);
  add_warnings(found.warnings, WarningKind::landmark, Severity::note, given.warnings);
  add_warnings(found.warnings, WarningKind::labels, Severity::note, label_warnings);
  add_warnings(found.warnings, WarningKind::labels, Severity::doubt, {sides});
  add_warnings(found.warnings, WarningKind::labels, Severity::doubt,
               {doubt_of_frames(data.settings.volume, data.settings.labels)});
  const LabelsInAir air = labels_in_air(**weighed, found.labels, data.settings.threads);
  doubt_what_is_air(air, found);
  add_warnings(found.warnings, WarningKind::labels, Severity::doubt, {in_words(air, found.labels)});
  if (auto elsewhere = compare_joints(found.landmarks, found.labels); !elsewhere)
    return tl::unexpected(elsewhere.error());
  else
    add_warnings(found.warnings, WarningKind::landmark, Severity::doubt, {*elsewhere});
  if (found.landmarks.empty())
    found.warnings.push_back({WarningKind::landmark, Severity::note,
                              "the labels came without landmarks, so joints are welded and segment frames "
                              "are unknown; give --landmarks"});
  auto answer = hand_on(data, found, **scan);
  data.keep(std::move(found));
  return answer;
}

Result<json> integrate_parts(RunData& data) {
  const auto scan = data.scan();
  if (!scan) return tl::unexpected(scan.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  MeasureOptions options = measuring(data.settings, **scan);
  options.segments = (*segmentation)->asked;
  std::optional<GreyVolume> of_mr;
  if ((*scan)->volume.quantity == Quantity::mr) {
    const auto reading = data.mr();
    if (!reading) return tl::unexpected(reading.error());
    of_mr = densities_by_parts(**reading, (*segmentation)->labels, options);
  }
  auto table = measure(of_mr ? *of_mr : (*scan)->volume, (*segmentation)->labels, (*segmentation)->landmarks,
                       options, completeness_of((*segmentation)->part));
  if (!table) return tl::unexpected(table.error());
  Warnings warnings = table->warnings;
  if (options.frames == "isb" && table->source.frames != "isb") warnings.emplace_back(no_isb_frames);
  const Warnings earlier = in_sentences((*segmentation)->warnings);
  table->warnings.insert(table->warnings.begin(), earlier.begin(), earlier.end());
  for (std::string& warning : table->warnings) warning = data.names.without_folders(std::move(warning));
  table->source.volume = data.names.name_of(data.settings.volume);
  table->source.quantity = (*scan)->reading;
  if (data.settings.labels.empty() || !data.settings.label_mapping.empty()) {
    auto verdict = read_verdict(data.file("segmentation/segmentation.json"));
    if (!verdict) return tl::unexpected(verdict.error());
    table->source.segmentation = std::move(*verdict);
  }
  for (const char* name : {"inertia/table.csv", "inertia/table.json"})
    if (auto written =
            write_whole(data.file(name), [&](const fs::path& beside) { return write_table(beside, *table); });
        !written)
      return tl::unexpected(written.error());
  for (const InertiaRow& row : table->rows)
    if (!row.flaw.empty()) warnings.push_back(row.part + ": " + row.flaw);
  if (data.settings.table_tolerance > 0)
    if (auto beyond = beyond_the_voxels(*table, data.settings.table_tolerance); !beyond.empty())
      warnings.push_back(std::move(beyond));
  json answer{{"warnings", warnings},
              {"notes", subject_of(**scan, data.settings.sex).notes},
              {"mass_kg", table->whole.inertial.mass},
              {"density_curve", table->source.density_curve},
              {"sampling", table->source.sampling}};
  data.keep(std::move(*table));
  return answer;
}

}  // namespace borelli
