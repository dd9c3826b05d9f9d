// borelli inertia: from a volume and its labels to the inertia table.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "error/file_ending.hpp"
#include "inertia/compare_tables.hpp"
#include "inertia/published_summary.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/body/belonging.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/files/subject.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/dicom_segmentation.hpp"
#include "segmentation/labelling/mr_tissues.hpp"
#include "segmentation/labelling/verdict.hpp"

namespace borelli {
namespace {

struct InertiaSettings {
  std::string volume, labels, names, mapping, landmarks, findings, quantity, convention, segments;
  MeasureOptions measure;
  std::vector<std::string> compared;
  std::vector<std::string> outputs;
};

// the map of all parts from which a map of segments was made (segmentation_files.hpp); empty if there is none
std::string parts_beside(const std::string& labels) {
  const std::filesystem::path path(labels);
  const auto all = path.parent_path() / "parts.nii.gz";
  std::error_code absent;
  return path.filename() == "labels.nii.gz" && std::filesystem::exists(all, absent) ? all.string() : "";
}

// the convention that cut the labels, which must be the one in their findings
Result<std::string> cuts_of(const InertiaSettings& settings) {
  if (settings.findings.empty())
    return settings.convention.empty() ? MeasureOptions{}.cuts : settings.convention;
  auto told = read_convention(settings.findings);
  if (!told) return told;
  if (told->empty()) *told = settings.convention.empty() ? MeasureOptions{}.cuts : settings.convention;
  if (!settings.convention.empty() && settings.convention != *told)
    return bad_use(
        "--convention " + settings.convention,
        fmt::format("the labels were cut by {}, as {} says; leave --convention out, or segment again with it",
                    *told, settings.findings));
  return told;
}

// How to measure: as asked, otherwise as the scan's header says.
Result<MeasureOptions> measure_options(const InertiaSettings& settings, const ScannedVolume& scan,
                                       const Command& command) {
  MeasureOptions options = settings.measure;
  options.threads = command.threads;
  if (options.pose.empty()) options.pose = scan.pose;
  Subject subject = subject_of(scan, options.sex);
  options.sex = std::move(subject.sex);
  for (const std::string& note : subject.notes) command.note(note);
  auto cuts = cuts_of(settings);
  if (!cuts) return tl::unexpected(cuts.error());
  options.cuts = std::move(*cuts);
  return options;
}

// A scan, read as far as it needs no parts.
struct ScanToMeasure {
  ScannedVolume scan;
  std::optional<ClassLabels> classes;  // of another program, with --label-mapping
  std::optional<MrReading> mr;         // of an MR scan

  const GreyVolume& weighed() const { return mr ? mr->density : scan.volume; }
};

Result<ScanToMeasure> read_tissues(const InertiaSettings& settings, ScannedVolume scan,
                                   const Command& command) {
  ScanToMeasure out{std::move(scan), {}, {}};
  const GreyVolume& grey = out.scan.volume;
  if (!settings.mapping.empty()) {
    auto read = read_classes(command, settings.labels, settings.names, settings.mapping, grey);
    if (!read) return tl::unexpected(read.error());
    out.classes = std::move(*read);
  }
  if (grey.quantity == Quantity::mr) {
    auto read = read_mr(grey, out.classes ? &*out.classes : nullptr, command.threads);
    if (!read) return tl::unexpected(read.error());
    out.mr = std::move(*read);
    command.warn(out.mr->warnings);
  }
  return out;
}

// The parts of a body and its landmarks, with what is known of their quality.
struct PartsToMeasure {
  LabelMap labels;
  Landmarks landmarks;
  PartCompleteness completeness;
  std::string verdict;
};

Result<PartsToMeasure> read_parts(const InertiaSettings& settings, const ScanToMeasure& body,
                                  const GivenLandmarks& given, const Command& command) {
  auto labels = read_labels(command, settings.labels, settings.names, &body.scan.volume.grid);
  if (!labels) return tl::unexpected(labels.error());
  command.warn(compare_sides(*labels));
  return PartsToMeasure{std::move(*labels), given.all(), {}, {}};
}

// Finds the parts with the help of another program's classes.
Result<PartsToMeasure> find_parts(const InertiaSettings& settings, const ScanToMeasure& body,
                                  const GivenLandmarks& given, const Command& command) {
  SegmentOptions parting;
  parting.threads = command.threads, parting.classes = &*body.classes;
  parting.given = body.mr ? given.all() : given.landmarks;
  if (!settings.convention.empty()) {
    const auto by = convention(settings.convention);
    if (!by) return tl::unexpected(by.error());
    parting.convention = *by;
  }
  auto found = segment(body.mr ? uniform_body(*body.mr) : body.scan.volume, parting);
  if (!found) return tl::unexpected(found.error());
  command.warn(doubt_of_classes(body.weighed(), *body.classes, command.threads));
  command.warn(in_sentences(found->warnings));
  PartsToMeasure out;
  out.verdict = in_words(verdict_of(*found));
  out.completeness = completeness_of(found->part);
  out.labels = std::move(found->labels), out.landmarks = std::move(found->landmarks);
  return out;
}

// Takes over what the findings say of the parts, and compares their volumes.
Result<void> use_findings(const std::string& path, PartsToMeasure& parts, const Command& command) {
  const auto findings = read_findings(path);
  if (!findings) return tl::unexpected(findings.error());
  parts.completeness = completeness_of(*findings);
  auto told = read_verdict(path);
  if (!told) return tl::unexpected(told.error());
  parts.verdict = std::move(*told);
  auto other = compare_volumes(*findings, parts.labels);
  if (!other) return tl::unexpected(other.error());
  command.warn(*other);
  return {};
}

// Compares the parts with the other inputs.
Result<void> check_parts(const InertiaSettings& settings, const ScanToMeasure& body,
                         const GivenLandmarks& given, PartsToMeasure& parts, const Command& command) {
  if (!settings.findings.empty())
    if (auto used = use_findings(settings.findings, parts, command); !used) return used;
  if (!settings.landmarks.empty() && !body.classes) {
    auto elsewhere = compare_joints(given.all(), parts.labels);
    if (!elsewhere) return tl::unexpected(elsewhere.error());
    command.warn(*elsewhere);
  }
  if (same_grid(parts.labels.grid, body.weighed().grid)) {
    const LabelsInAir air = labels_in_air(body.weighed(), parts.labels, command.threads);
    doubt_what_is_air(air, parts.labels, parts.completeness);
    command.warn(in_words(air, parts.labels));
  }
  return {};
}

Result<InertiaTable> make_table_from_files(const InertiaSettings& settings, const Command& command) {
  auto scan = read_volume(command, settings.volume, settings.quantity);
  if (!scan) return tl::unexpected(scan.error());
  const auto given = read_given_landmarks(command, settings.landmarks);
  if (!given) return tl::unexpected(given.error());
  auto options = measure_options(settings, *scan, command);
  if (!options) return tl::unexpected(options.error());
  auto body = read_tissues(settings, std::move(*scan), command);
  if (!body) return tl::unexpected(body.error());
  auto parts = (body->classes ? find_parts : read_parts)(settings, *body, *given, command);
  if (!parts) return tl::unexpected(parts.error());
  command.warn(doubt_of_frames(settings.volume, settings.labels));
  if (const auto all = parts_beside(settings.labels); !body->classes && !all.empty())
    command.warn(
        fmt::format("{} contains only the requested segments, so the rest of the body would count as their "
                    "skin; measure {} with --segments instead",
                    settings.labels, all));
  auto asked = choose_segments(settings.segments, parts->labels.names);
  if (!asked) return tl::unexpected(asked.error());
  options->segments = std::move(*asked);
  if (auto fine = check_parts(settings, *body, *given, *parts, command); !fine)
    return tl::unexpected(fine.error());
  if (body->mr) body->mr->density = densities_by_parts(*body->mr, parts->labels, *options);
  auto table =
      measure(body->weighed(), std::move(parts->labels), parts->landmarks, *options, parts->completeness);
  if (!table) return tl::unexpected(table.error());
  table->source.volume = command.names().name_of(settings.volume);
  table->source.quantity = body->scan.reading;
  table->source.segmentation = parts->verdict;
  command.warn(table->warnings);
  if (options->frames == "isb" && table->source.frames != "isb") command.warn(std::string(no_isb_frames));
  table->warnings = command.warnings_in_files();
  return table;
}

std::string percent(double share) { return std::isnan(share) ? "" : fmt::format("{:.2f}", 100 * share); }

std::string radii(const Eigen::Vector3d& r) {
  return fmt::format("{:.1f} {:.1f} {:.1f}", 100 * r[0], 100 * r[1], 100 * r[2]);
}

void print_row(const InertiaTable& table, const InertiaRow& row) {
  if (row.completeness == Completeness::absent) {
    fmt::print("{:<17} {:<7}\n", row.part, row.notes.empty() ? "absent" : row.notes.front());
    return;
  }
  const auto numbers = anatomical_numbers(row);
  const bool length = numbers && numbers->length > 0;
  const Comparison deleva = compare(table, row, "deleva1996");
  const auto* p = deleva.published;
  const auto sd = std::ranges::find(row.deviations, "mass_kg", &EntryDeviation::entry);
  fmt::print("{:<17} {:<7} {:>8.3f} {:>6} {:>6} {:>6}  {:>9} {:>6} {:>6} {:>6}  {:<15} {:<15}\n", row.part,
             name_of(row.completeness), row.inertial.mass,
             sd == row.deviations.end() ? "" : fmt::format("{:.3f}", sd->total), percent(table.share(row)),
             p && deleva.mass ? percent(p->mass_share) : "",
             length ? fmt::format("{}-{}", row.frame->from, row.frame->to) : "",
             length ? fmt::format("{:.0f}", 1000 * numbers->length) : "",
             length ? fmt::format("{:.1f}", 100 * numbers->centre_along) : "",
             deleva.shape ? fmt::format("{:.1f}", 100 * p->centre_along) : "",
             length ? radii(numbers->radii) : "",
             deleva.shape               ? radii(p->radii)
             : table.source.sex.empty() ? ""
                                        : "not comparable");
}

void print_table(const InertiaTable& table) {
  const InertiaSource& source = table.source;
  fmt::print("{}: {}\n", source.volume, source.quantity);
  if (!source.density_curve.empty())
    fmt::print("Density curve: {} ({})\n", source.density_curve, source.density_source);
  fmt::print("Voxels: {}\nCuts: {}; frames: {}; pose: {}; compared with: de Leva (1996){}\n\n",
             source.sampling, source.cuts, source.frames, source.pose.empty() ? "not stated" : source.pose,
             source.sex.empty() ? ", not shown (give --sex)" : ", " + source.sex);
  if (!source.segmentation.empty()) fmt::print("Segmentation: {}\n\n", source.segmentation);
  fmt::print("{:<17} {:<7} {:>8} {:>6} {:>6} {:>6}  {:>9} {:>6} {:>6} {:>6}  {:<15} {:<15}\n", "part", "",
             "mass kg", "sd", "%", "deLeva", "endpoints", "mm", "centre", "deLeva", "radii X Y Z %",
             "de Leva");
  for (const InertiaRow& row : table.rows) print_row(table, row);
  print_row(table, table.whole);
  std::vector<std::pair<std::string, std::string>> notes;  // each with its parts
  for (const InertiaRow& row : table.rows) {
    if (!row.flaw.empty()) fmt::print("\nWarning: {}: {}", row.part, row.flaw);
    for (const auto& note : row.notes) {
      const auto same = std::ranges::find(notes, note, &std::pair<std::string, std::string>::first);
      if (same == notes.end())
        notes.emplace_back(note, row.part);
      else
        same->second += ", " + row.part;
    }
  }
  for (const auto& [note, of] : notes) fmt::print("\n{}: {}", of, note);
  if (!stated_absent(table).empty())
    fmt::print(
        "\nPercentages refer to the mass that is present, because --absent names parts that the body lacks.");
  else if (table.whole.completeness != Completeness::whole)
    fmt::print("\nPercentages refer to the labelled mass, because not every part is there and whole.");
  fmt::print("\n");
  if (!source.sex.empty())
    for (const PublishedSummary& summary : published_summaries(table))
      fmt::print("Published: {}\n", in_words(summary));
  const Eigen::Vector3d& c = table.whole.inertial.centre;
  fmt::print("Gravity centre of the whole body (left, back, up): {:.4f} {:.4f} {:.4f} m\n", c[0], c[1], c[2]);
}

void print_differences(const std::vector<NamedTable>& tables) {
  fmt::print("{:<17} {:<22} {:>12} {:>12} {:>9} {:>8}\n", "part", "entry", "first", "second", "differs %",
             "in sds");
  for (const TableDifference& d : differences(tables[0].table, tables[1].table))
    if (d.entry.starts_with("mass") || d.entry == "length_m" || d.entry == "centre_pct" ||
        d.entry.ends_with("_pct"))
      fmt::print("{:<17} {:<22} {:>12.5g} {:>12.5g} {:>9} {:>8}\n", d.part, d.entry, d.first, d.second,
                 std::isfinite(d.percent()) ? fmt::format("{:+.2f}", d.percent()) : "",
                 d.deviation ? fmt::format("{:+.1f}", (d.second - d.first) / *d.deviation) : "");
}

void print_group(const std::vector<NamedTable>& tables) {
  const GroupTable group = group_of(tables);
  fmt::print("{:<17} {:<12} {:>6} {:>12} {:>12}  {}\n", "part", "entry", "bodies", "mean", "sd",
             "= intercept + per metre of stature + per kilogram; r2; sd about it");
  for (const GroupEntry& e : group.entries) {
    if (e.entry != "mass_kg" && e.entry != "mass_pct" && e.entry != "length_m" && e.entry != "centre_pct")
      continue;
    fmt::print("{:<17} {:<12} {:>6} {:>12.5g} {:>12.4g}", e.part, e.entry, e.bodies, e.mean, e.sd);
    if (const auto& r = e.regression)
      fmt::print("  {:.4g} {:+.4g} {:+.4g}; {:.2f}; {:.3g}", r->intercept, r->per_metre, r->per_kilogram,
                 r->r2, r->residual_sd);
    fmt::print("\n");
  }
  if (!group.no_regression.empty()) fmt::print("{}\n", group.no_regression);
}

Result<void> check_outputs(const InertiaSettings& s) {
  for (const std::string& output : s.outputs) {
    if (ending_of(output) != ".csv" && ending_of(output) != ".json")
      return bad_use(output, "is not a .csv or .json file; name a table with one of these endings");
    if (auto fine = check_writable(output); !fine) return fine;
  }
  return {};
}

Result<nlohmann::json> compare_files(const InertiaSettings& settings, const Command& command) {
  if (auto fine = check_outputs(settings); !fine) return tl::unexpected(fine.error());
  std::vector<NamedTable> tables;
  for (const std::string& path : settings.compared) {
    auto table = read_table(command, path);
    if (!table) return tl::unexpected(table.error());
    tables.push_back({path, std::move(*table)});
  }
  if (auto fine = check_comparable(tables); !fine) return tl::unexpected(fine.error());
  command.warn(remarks_on(tables));
  for (NamedTable& table : tables) table.name = command.names().name_of(table.name);
  for (const std::string& output : settings.outputs)
    if (auto written = write_whole(
            output, ending_of(output) == ".csv" ? comparison_csv(tables) : comparison_json(tables));
        !written)
      return tl::unexpected(written.error());
  if (!command.json && tables.size() == 2) print_differences(tables);
  if (!command.json && tables.size() > 2) print_group(tables);
  return nlohmann::json::parse(comparison_json(tables));
}

Result<nlohmann::json> work(const InertiaSettings& settings, const Command& command) {
  if (!settings.compared.empty()) {
    if (!settings.volume.empty() || !settings.labels.empty())
      return bad_use("--compare", "compares existing tables; leave out --volume and --labels");
    return compare_files(settings, command);
  }
  if (settings.volume.empty() || settings.labels.empty())
    return bad_use("inertia", "needs --volume and --labels, or --compare with two or more tables");
  if (!settings.findings.empty() && !settings.mapping.empty())
    return bad_use("--findings",
                   "has no effect with --label-mapping, because the parts are then found again; leave one of "
                   "the two out");
  if (settings.measure.frames == "isb" && settings.landmarks.empty() && settings.mapping.empty())
    return bad_use("--frames isb", "needs landmarks to define the axes; add --landmarks FILE");
  if (auto fine = check_outputs(settings); !fine) return tl::unexpected(fine.error());
  const auto table = make_table_from_files(settings, command);
  if (!table) return tl::unexpected(table.error());
  for (const std::string& output : settings.outputs)
    if (auto written = write_whole(output, [&](const auto& path) { return write_table(path, *table); });
        !written)
      return tl::unexpected(written.error());
  if (!command.json) print_table(*table);
  return nlohmann::json::parse(to_json(*table));
}

}  // namespace

void add_inertia(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand(
      "inertia", "Measure mass, gravity centre and inertia tensor of each labelled part");
  auto settings = std::make_shared<InertiaSettings>();
  add_shared(*verb, flags::volume, settings->volume);
  add_shared(*verb, flags::labels, settings->labels,
             "; it holds parts, or with --label-mapping the classes of another program");
  add_output(*verb, settings->outputs, "FILE", "Table to write, .csv or .json; may be repeated")
      ->allow_extra_args(false);
  add_shared(*verb, flags::quantity, settings->quantity, flags::quantity_default);
  add_shared(*verb, flags::landmarks, settings->landmarks, "; for segment lengths and axes");
  verb->add_option("--findings", settings->findings,
                   "segmentation.json of `borelli segment`; it says which parts the scan cuts off")
      ->type_name("FILE");
  add_shared(*verb, flags::sex, settings->measure.sex, flags::sex_compares);
  add_shared(*verb, flags::label_mapping, settings->mapping);
  add_shared(*verb, flags::label_names, settings->names);
  add_shared(*verb, flags::density_curve, settings->measure.density_curve,
             fmt::format(" (default: {})", default_density_curve));
  add_shared(*verb, flags::convention, settings->convention,
             ": as `borelli segment` cuts, or by a published convention (default: as --findings says, "
             "otherwise deleva1996)")
      ->check(one_of(cut_names));
  add_shared(*verb, flags::frames, settings->measure.frames)->capture_default_str();
  add_shared(*verb, flags::segments, settings->segments);
  add_shared(*verb, flags::keep_paths, command.keep_paths);
  verb->add_option("--compare", settings->compared,
                   "Compare these tables (.json) instead: two give differences, more give means and "
                   "regressions on stature and mass")
      ->type_name("FILE");
  add_shared(*verb, flags::stature, settings->measure.stature_m, "; group tables need it");
  add_shared(*verb, flags::pose, settings->measure.pose);
  group_options(*verb, "Labels of another program", {"--label-mapping", "--label-names"});
  group_options(*verb, "Table",
                {"--density-curve", "--convention", "--frames", "--segments", "--keep-paths"});
  group_options(*verb, "Comparison of bodies", {"--compare", "--stature", "--pose"});
  verb->callback([&command, settings] {
    command.work = [settings](const Command& c) -> Result<nlohmann::json> { return work(*settings, c); };
  });
}

}  // namespace borelli
