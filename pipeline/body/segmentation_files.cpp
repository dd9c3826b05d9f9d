#include "pipeline/body/segmentation_files.hpp"

#include <algorithm>

#include "error/json_text.hpp"
#include "pipeline/files/colour_table.hpp"
#include "pipeline/files/warnings_json.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/dicom_labels.hpp"
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/labelling/verdict.hpp"

namespace borelli {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

// The object in segmentation.json; empty if the file is damaged. Errors: as read_input_file.
Result<json> read_account(const fs::path& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto account = parse_json(*bytes, path.string());
  return account && account->is_object() ? *account : json::object();
}

}  // namespace

json segmentation_account(const Segmentation& segmentation, const std::string& input,
                          const std::string& reading) {
  json all = json::object(), segments = json::object();
  const auto& asked = segmentation.asked;
  for (const Segment& segment : asked) segments[segment.name] = segment.of;
  const auto wanted = [&](std::string_view part) {
    return asked.empty() || std::ranges::any_of(asked, [&](const Segment& segment) {
             return std::ranges::find(segment.of, part) != segment.of.end();
           });
  };
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (!wanted(parts[n].name)) continue;
    const PartFinding& finding = segmentation.part[n];
    all[std::string(parts[n].name)] = {{"label", n},
                                       {"coverage", name_of(finding.coverage)},
                                       {"volume_mm3", finding.volume},
                                       {"confidence", finding.confidence},
                                       {"note", finding.note}};
  }
  json account{{"input", input},
               {"reading", reading},
               {"convention", name_of(segmentation.convention)},
               {"parts", all}};
  account.update(warnings_entry(segmentation.warnings));
  const SegmentationVerdict verdict = verdict_of(segmentation);
  account["verdict"] = name_of(verdict.verdict);
  account["verdict_reasons"] = verdict.reasons;
  if (any_absent(segmentation.absent)) account["absent"] = in_text(segmentation.absent);
  if (!asked.empty()) account["segments"] = segments;
  return account;
}

Result<void> write_label_files(const fs::path& path, const LabelMap& labels) {
  const std::string names = fs::path(names_file(path.string())).filename(),
                    colours = fs::path(colour_file(path.string())).filename(), map = path.filename();
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  return write_whole_set(folder, {names, colours, map}, [&](const fs::path& beside) -> Result<void> {
    if (auto written = write_labels((beside / map).string(), labels); !written) return written;
    return write_bytes(beside / colours, colour_table(labels));
  });
}

Result<void> write_dicom_label_file(const fs::path& path, const LabelMap& labels, const DicomSource* source,
                                    bool patient) {
  return write_whole(path, [&](const fs::path& beside) {
    return write_dicom_labels(beside.string(), labels,
                              {.source = source, .patient = patient, .version = BORELLI_VERSION});
  });
}

Result<void> write_segmentation(const fs::path& folder, const Segmentation& segmentation, const json& account,
                                const std::string& given) {
  std::error_code absent;
  for (const char* name : all_parts_file_names) fs::remove(folder / name, absent);  // from an earlier choice
  const bool all = segmentation.asked.empty();
  if (auto written =
          write_label_files(folder / (all ? "labels.nii.gz" : "parts.nii.gz"), segmentation.labels);
      !written)
    return written;
  if (!all) {
    const LabelMap asked = labels_of_segments(segmentation.labels, segmentation.asked);
    if (auto written = write_label_files(folder / "labels.nii.gz", asked); !written) return written;
  }
  const auto marks = write_whole(folder / "landmarks.json", [&](const fs::path& path) {
    return write_landmarks(path.string(), segmentation.landmarks);
  });
  if (!marks) return marks;
  if (const fs::path points = folder / "landmarks.mrk.json";
      given.empty() || !fs::equivalent(points, given, absent)) {
    const auto markups = write_whole(points, [&](const fs::path& path) {
      return write_markups(path.string(), segmentation.landmarks, segmentation.given);
    });
    if (!markups) return markups;
  }
  return write_whole(folder / "segmentation.json", json_text(account, 1) + "\n");
}

Result<std::string> read_convention(const fs::path& path) {
  const auto account = read_account(path);
  if (!account) return tl::unexpected(account.error());
  if (!account->contains("convention")) return std::string();
  const json& convention = (*account)["convention"];
  if (!convention.is_string()) return failure(path.string(), "\"convention\" must be a text");
  return convention.get<std::string>();
}

Result<std::vector<Warning>> read_warnings(const fs::path& path) {
  const auto account = read_account(path);
  if (!account) return tl::unexpected(account.error());
  if (account->contains("single_warnings")) return warnings_from((*account)["single_warnings"]);
  std::vector<Warning> warnings;  // from an older file
  if (account->contains("warnings"))
    for (const json& warning : (*account)["warnings"])
      if (warning.is_string())
        add_warnings(warnings, WarningKind::scan, Severity::note, {warning.get<std::string>()});
  return warnings;
}

Result<std::string> read_verdict(const fs::path& path) {
  const auto account = read_account(path);
  if (!account) return tl::unexpected(account.error());
  const auto verdict = account->find("verdict"), reasons = account->find("verdict_reasons");
  if (verdict == account->end() || !verdict->is_string()) return std::string();
  std::string words = verdict->get<std::string>();
  if (reasons != account->end() && reasons->is_array() && !reasons->empty() && reasons->front().is_string())
    words += ": " + reasons->front().get<std::string>();
  return words;
}

Result<AbsentParts> read_absent(const fs::path& path) {
  const auto account = read_account(path);
  if (!account) return tl::unexpected(account.error());
  const auto absent = account->find("absent");
  if (absent == account->end()) return AbsentParts{};
  if (!absent->is_string()) return failure(path.string(), "\"absent\" must be a text");
  return parse_absent(absent->get<std::string>());
}

Result<std::array<PartFinding, parts.size()>> read_findings(const fs::path& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto parsed = parse_json(*bytes, path.string());
  if (!parsed) return tl::unexpected(parsed.error());
  if (!parsed->is_object() || !parsed->contains("parts") || !(*parsed)["parts"].is_object())
    return bad_use(
        path.string(),
        "is not a record of a segmentation; expected segmentation.json as `borelli segment` writes it");
  std::array<PartFinding, parts.size()> findings{};
  for (const auto& [name, entry] : (*parsed)["parts"].items()) {
    const std::string where = path.string() + ": " + name;
    const int label = part_label(name);
    if (label == 0) return failure(path.string(), "names an unknown part: " + name);
    if (!entry.is_object() || !entry.contains("coverage"))
      return failure(where, "has no \"coverage\"; expected absent, cut or whole");
    const json kinds{{"coverage", ""}, {"volume_mm3", 0}, {"confidence", 0}, {"note", ""}};
    if (auto fine = check_kinds(entry, kinds, where); !fine) return tl::unexpected(fine.error());
    PartFinding& finding = findings[static_cast<std::size_t>(label)];
    const std::string coverage = entry["coverage"];
    bool known = false;
    for (const Coverage c : {Coverage::absent, Coverage::cut, Coverage::whole})
      if (coverage == name_of(c)) finding.coverage = c, known = true;
    if (!known)
      return failure(path.string(),
                     name + ": coverage is \"" + coverage + "\"; expected absent, cut or whole");
    finding.volume = entry.value("volume_mm3", 0.0);
    finding.confidence = entry.value("confidence", 0.0);
    finding.note = entry.value("note", "");
  }
  return findings;
}

}  // namespace borelli
