#include "inertia/table_file.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "error/file_ending.hpp"
#include "error/json_text.hpp"
#include "error/plain_cell.hpp"
#include "inertia/csv.hpp"
#include "inertia/entries.hpp"
#include "inertia/published_summary.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr std::string_view format_name = "borelli inertia table, 1";
constexpr double absent = std::numeric_limits<double>::quiet_NaN();

// ---- CSV: a row is a list of column names and fields; the first row gives the header

using Fields = std::vector<std::pair<std::string, std::string>>;

void add(Fields& fields, std::string column, double value) {
  fields.emplace_back(std::move(column), std::isnan(value) ? "" : fmt::format("{:.9g}", value));
}

void add(Fields& fields, std::string column, std::string_view text) {
  fields.emplace_back(std::move(column), csv_field(text));
}

void add(Fields& fields, const std::array<std::string, 3>& columns, const Vector3d& v) {
  for (int n = 0; n < 3; ++n) add(fields, columns[static_cast<std::size_t>(n)], v[n]);
}

void add_deviations(Fields& fields, const InertiaTable& table, const InertiaRow& row,
                    const std::vector<Entry>& entries) {
  const auto of = [&](const std::string& name) {
    const auto it = std::ranges::find(row.deviations, name, &EntryDeviation::entry);
    return it == row.deviations.end() ? nullptr : &*it;
  };
  for (const Entry& entry : entries) {
    const EntryDeviation* deviation = of(entry.name);
    add(fields, entry.name + "_sd", deviation ? deviation->total : absent);
  }
  const EntryDeviation* mass = of("mass_kg");
  for (std::size_t n = 0; n < table.causes.size(); ++n)
    add(fields, "mass_sd_" + table.causes[n] + "_kg",
        mass && n < mass->by_cause.size() ? mass->by_cause[n] : absent);
}

void add_published(Fields& fields, const InertiaTable& table, const InertiaRow& row, std::string_view name) {
  const Comparison beside = compare(table, row, name);
  const std::string prefix = std::string(name) + "_";
  const auto* p = beside.published;
  const auto own = anatomical_numbers(row);
  const bool shape = p && beside.shape && own;
  add(fields, prefix + "mass_pct", p && beside.mass ? 100 * p->mass_share : absent);
  add(fields, prefix + "mass_diff_pct",
      p && beside.mass ? 100 * (table.share(row) / p->mass_share - 1) : absent);
  add(fields, prefix + "centre_pct", shape ? 100 * p->centre_along : absent);
  add(fields, prefix + "centre_diff_pct", shape ? 100 * (own->centre_along / p->centre_along - 1) : absent);
  add(fields, {prefix + "rx_pct", prefix + "ry_pct", prefix + "rz_pct"},
      shape ? Vector3d(100 * p->radii) : Vector3d::Constant(absent));
  add(fields, {prefix + "rx_diff_pct", prefix + "ry_diff_pct", prefix + "rz_diff_pct"},
      shape ? Vector3d(100 * (own->radii.array() / p->radii.array() - 1)) : Vector3d::Constant(absent));
  add(fields, prefix + "why_not", beside.why_not);
}

Fields csv_row(const InertiaTable& table, const InertiaRow& row) {
  Fields fields;
  const bool there = row.completeness != Completeness::absent;
  add(fields, "part", row.part);
  add(fields, "completeness", name_of(row.completeness));
  add(fields, "pose", table.source.pose);
  add(fields, "from", row.frame ? row.frame->from : "");
  add(fields, "to", row.frame ? row.frame->to : "");
  add(fields, "cuts", row.frame ? row.frame->cuts : "");
  const auto entries = entries_of(table, row);
  for (const Entry& entry : entries) add(fields, entry.name, entry.value);
  const PrincipalAxes principal = there
                                      ? row.inertial.principal()
                                      : PrincipalAxes{Vector3d::Constant(absent), Matrix3d::Constant(absent)};
  for (int n = 0; n < 3; ++n) {
    const std::string axis = fmt::format("axis{}_", n + 1);
    add(fields, {axis + "x", axis + "y", axis + "z"}, principal.axes.col(n));
  }
  if (!table.causes.empty()) add_deviations(fields, table, row, entries);
  for (const auto name : published_tables) add_published(fields, table, row, name);
  add(fields, "flaw", row.flaw);
  add(fields, "axes", row.frame ? row.frame->axes : "");
  add(fields, "notes", fmt::format("{}", fmt::join(row.notes, "; ")));
  return fields;
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return plain_comment(text) + "\n";
}

// ---- JSON

Json vector_json(const Vector3d& v) { return {v[0], v[1], v[2]}; }

Json matrix_json(const Matrix3d& m) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back(vector_json(m.row(r)));
  return rows;
}

Json bare_frame_json(const SegmentFrame& frame) {
  return {{"segment", frame.segment},
          {"from", frame.from},
          {"to", frame.to},
          {"from_point_m", vector_json(frame.from_point)},
          {"to_point_m", vector_json(frame.to_point)},
          {"long_axis", vector_json(frame.long_axis)},
          {"anatomical_axes_in_patient", matrix_json(frame.R_WA)},
          {"axes", frame.axes},
          {"cuts", frame.cuts}};
}

Json frame_json(const SegmentFrame& frame) {
  Json json = bare_frame_json(frame);
  if (!frame.origin_name.empty()) {
    json["origin"] = frame.origin_name;
    json["origin_point_m"] = vector_json(frame.origin);
  }
  return json;
}

Json published_json(const InertiaTable& table, const InertiaRow& row, std::string_view name) {
  const Comparison beside = compare(table, row, name);
  if (!beside.published) return {{"why_not", beside.why_not}};
  const auto own = anatomical_numbers(row);
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  Json json = Json::object();
  if (beside.shape && own) {
    const Vector3d differ = 100 * (own->radii.array() / beside.published->radii.array() - 1);
    json["centre_pct"] = known(100 * beside.published->centre_along);
    json["centre_diff_pct"] = known(100 * (own->centre_along / beside.published->centre_along - 1));
    for (int n = 0; n < 3; ++n) {
      json["radii_pct"].push_back(known(100 * beside.published->radii[n]));
      json["radii_diff_pct"].push_back(known(differ[n]));
    }
  }
  if (beside.mass) {
    json["mass_pct"] = 100 * beside.published->mass_share;
    json["mass_diff_pct"] = 100 * (table.share(row) / beside.published->mass_share - 1);
  }
  if (!beside.why_not.empty()) json["why_not"] = beside.why_not;
  return json;
}

Json derived_json(const InertiaTable& table, const InertiaRow& row) {
  const PrincipalAxes principal = row.inertial.principal();
  Json json{{"mass_pct", 100 * table.share(row)},
            {"principal_moments_kgm2", vector_json(principal.moments)},
            {"principal_axes_columns", matrix_json(principal.axes)}};
  if (const auto anatomical = anatomical_numbers(row)) {
    json["anatomical_tensor_kgm2"] = matrix_json(anatomical->tensor);
    if (!row.frame->origin_name.empty())
      json["centre_in_frame_m"] =
          vector_json(row.frame->R_WA.transpose() * (row.inertial.centre - row.frame->origin));
    if (anatomical->length > 0) {
      json["length_m"] = anatomical->length;
      json["centre_pct"] = 100 * anatomical->centre_along;
      json["radii_pct"] = vector_json(100 * anatomical->radii);
    }
  }
  for (const auto name : published_tables) json[std::string(name)] = published_json(table, row, name);
  return json;
}

Json row_json(const InertiaTable& table, const InertiaRow& row) {
  Json json{{"part", row.part}, {"completeness", name_of(row.completeness)}, {"notes", row.notes}};
  if (row.completeness != Completeness::absent) {
    json["volume_m3"] = row.volume;
    json["mass_kg"] = row.inertial.mass;
    json["centre_m"] = vector_json(row.inertial.centre);
    json["tensor_kgm2"] = matrix_json(row.inertial.tensor);
    if (!row.flaw.empty()) json["flaw"] = row.flaw;
  }
  if (row.frame) json["frame"] = frame_json(*row.frame);
  if (row.completeness != Completeness::absent) json["derived"] = derived_json(table, row);
  for (const EntryDeviation& deviation : row.deviations) {
    Json& one = json["deviations"][deviation.entry];
    one["total"] = deviation.total;
    for (std::size_t n = 0; n < std::min(table.causes.size(), deviation.by_cause.size()); ++n)
      one[table.causes[n]] = deviation.by_cause[n];
  }
  return json;
}

constexpr std::array<std::pair<const char*, std::string InertiaSource::*>, 11> source_fields{
    {{"volume", &InertiaSource::volume},
     {"quantity", &InertiaSource::quantity},
     {"density_curve", &InertiaSource::density_curve},
     {"density_source", &InertiaSource::density_source},
     {"sampling", &InertiaSource::sampling},
     {"sex", &InertiaSource::sex},
     {"pose", &InertiaSource::pose},
     {"cuts", &InertiaSource::cuts},
     {"frames", &InertiaSource::frames},
     {"segments", &InertiaSource::segments},
     {"segmentation", &InertiaSource::segmentation}}};

// ---- reading: errors are thrown as sentences and caught in table_from_json

struct Damaged {
  std::string what;
};

const Json& member(const Json& json, const char* key, const std::string& owner) {
  if (!json.is_object() || !json.contains(key)) throw Damaged{fmt::format("{} has no \"{}\"", owner, key)};
  return json[key];
}

std::string text(const Json& json, const char* key, const std::string& owner) {
  const Json& value = member(json, key, owner);
  if (!value.is_string()) throw Damaged{fmt::format("\"{}\" of {} must be a text", key, owner)};
  return value.get<std::string>();
}

double number(const Json& value, const char* key, const std::string& owner) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw Damaged{fmt::format("\"{}\" of {} must be a finite number", key, owner)};
  return value.get<double>();
}

Vector3d vector(const Json& value, const char* key, const std::string& owner) {
  if (!value.is_array() || value.size() != 3)
    throw Damaged{fmt::format("\"{}\" of {} must contain three numbers", key, owner)};
  return {number(value[0], key, owner), number(value[1], key, owner), number(value[2], key, owner)};
}

Matrix3d matrix(const Json& value, const char* key, const std::string& owner) {
  if (!value.is_array() || value.size() != 3)
    throw Damaged{fmt::format("\"{}\" of {} must contain three rows of three numbers", key, owner)};
  Matrix3d m;
  for (int r = 0; r < 3; ++r) m.row(r) = vector(value[static_cast<std::size_t>(r)], key, owner);
  return m;
}

SegmentFrame frame_from(const Json& json, const std::string& owner) {
  const auto vector_of = [&](const char* key) { return vector(member(json, key, owner), key, owner); };
  const char* axes = "anatomical_axes_in_patient";
  SegmentFrame frame{text(json, "segment", owner),
                     text(json, "from", owner),
                     text(json, "to", owner),
                     vector_of("from_point_m"),
                     vector_of("to_point_m"),
                     vector_of("long_axis"),
                     matrix(member(json, axes, owner), axes, owner),
                     text(json, "axes", owner),
                     text(json, "cuts", owner)};
  if (json.contains("origin")) {
    frame.origin_name = text(json, "origin", owner);
    frame.origin = vector_of("origin_point_m");
  }
  if (!(frame.R_WA * frame.R_WA.transpose()).isIdentity(1e-6) || frame.R_WA.determinant() < 0)
    throw Damaged{fmt::format("\"{}\" of {} must be orthonormal and right-handed", axes, owner)};
  return frame;
}

std::vector<EntryDeviation> deviations_from(const Json& json, const std::string& owner) {
  std::vector<EntryDeviation> all;
  if (!json.contains("deviations")) return all;
  for (const auto& [entry, by] : json["deviations"].items()) {
    EntryDeviation deviation{entry, number(member(by, "total", owner), "total", owner), {}};
    for (const auto& [cause, value] : by.items())
      if (cause != "total") deviation.by_cause.push_back(number(value, "deviations", owner));
    all.push_back(std::move(deviation));
  }
  return all;
}

std::vector<std::string> texts_from(const Json& json, const char* key, const std::string& owner) {
  std::vector<std::string> texts;
  if (!json.contains(key)) return texts;
  for (const Json& one : json[key]) {
    if (!one.is_string()) throw Damaged{fmt::format("\"{}\" of {} must contain only texts", key, owner)};
    texts.push_back(one.get<std::string>());
  }
  return texts;
}

InertiaRow row_from(const Json& json, std::size_t number_of_row) {
  InertiaRow row;
  row.part = text(json, "part", fmt::format("row {}", number_of_row));
  const std::string name = text(json, "completeness", row.part);
  bool known = false;
  for (const auto c : {Completeness::absent, Completeness::cut, Completeness::whole})
    if (name == name_of(c)) row.completeness = c, known = true;
  if (!known) throw Damaged{fmt::format("{} is \"{}\", expected absent, cut or whole", row.part, name)};
  if (row.completeness != Completeness::absent) {
    row.volume = number(member(json, "volume_m3", row.part), "volume_m3", row.part);
    row.inertial.mass = number(member(json, "mass_kg", row.part), "mass_kg", row.part);
    row.inertial.centre = vector(member(json, "centre_m", row.part), "centre_m", row.part);
    row.inertial.tensor = matrix(member(json, "tensor_kgm2", row.part), "tensor_kgm2", row.part);
  }
  if (json.contains("frame")) row.frame = frame_from(json["frame"], "the frame of " + row.part);
  row.deviations = deviations_from(json, row.part);
  row.notes = texts_from(json, "notes", row.part);
  return row;
}

InertiaTable table_from(const Json& json) {
  if (const std::string format = text(json, "format", "the file"); format != format_name)
    throw Damaged{fmt::format("its format is \"{}\", expected \"{}\"", format, format_name)};
  InertiaSource source;
  const Json& from = member(json, "source", "the file");
  source.frames = "joints";  // older tables do not state it
  for (const auto& [key, field] : source_fields)
    if (from.contains(key) || (field != &InertiaSource::frames && field != &InertiaSource::segments &&
                               field != &InertiaSource::segmentation))
      source.*field = text(from, key, "\"source\"");
  if (from.contains("stature_m")) source.stature_m = number(from["stature_m"], "stature_m", "\"source\"");
  const Json& parts = member(json, "parts", "the file");
  if (!parts.is_array()) throw Damaged{"\"parts\" must be a list"};
  std::vector<InertiaRow> rows;
  for (const Json& part : parts) rows.push_back(row_from(part, rows.size() + 1));
  InertiaTable table = make_table(std::move(source), std::move(rows));
  if (!table.source.segments.empty()) table.whole = row_from(member(json, "body", "the file"), 0);
  table.warnings = texts_from(json, "warnings", "the file");
  table.causes = texts_from(json, "deviation_causes", "the file");
  if (json.contains("body")) {
    table.whole.deviations = deviations_from(json["body"], "body");
    table.whole.notes = texts_from(json["body"], "notes", "body");
  }
  return table;
}

}  // namespace

std::string to_csv(const InertiaTable& table) {
  std::string out;
  out += fmt::format("# {}\n", format_name);
  for (const auto& [key, field] : source_fields)
    if (!(table.source.*field).empty()) out += one_line(fmt::format("# {}: {}", key, table.source.*field));
  for (const std::string& warning : table.warnings) out += one_line("# warning: " + warning);
  out +=
      "# centre and patient_I in patient axes: x left, y posterior, z superior; I about the gravity centre, "
      "as matrix "
      "entries (Ixy = -integral xy dm)\n"
      "# anatomical axes: X anterior, Y proximal, Z right; rx, ry, rz: radii of gyration about them, percent "
      "of "
      "length\n"
      "# mass_pct: percent of the mass of all parts (the row body); centre_pct: from endpoint `from` towards "
      "`to`, "
      "percent of "
      "length\n";
  for (const PublishedSummary& one : published_summaries(table))
    out += one_line("# compared with " + in_words(one));
  if (!table.causes.empty())
    out += fmt::format("# NAME_sd: standard deviation of NAME; mass_sd_CAUSE_kg: by cause ({})\n",
                       fmt::join(table.causes, ", "));
  std::vector<const InertiaRow*> rows;
  for (const InertiaRow& row : table.rows) rows.push_back(&row);
  rows.push_back(&table.whole);
  for (const InertiaRow* row : rows) {
    const Fields fields = csv_row(table, *row);
    std::string header, line;
    for (const auto& [column, field] : fields) {
      header += (header.empty() ? "" : ",") + column;
      line += (&field == &fields.front().second ? "" : ",") + field;
    }
    if (row == rows.front()) out += header + "\n";
    out += line + "\n";
  }
  return out;
}

std::string to_json(const InertiaTable& table) {
  Json source;
  for (const auto& [key, field] : source_fields) source[key] = table.source.*field;
  if (table.source.stature_m > 0) source["stature_m"] = table.source.stature_m;
  Json summary = Json::array();
  for (const PublishedSummary& one : published_summaries(table)) summary.push_back(in_words(one));
  Json parts = Json::array();
  for (const InertiaRow& row : table.rows) parts.push_back(row_json(table, row));
  const Json json{
      {"format", format_name},
      {"frame",
       "patient axes in metres: x left, y posterior, z superior; tensors about the gravity centre, as "
       "matrix entries, Ixy = -integral xy dm"},
      {"source", source},
      {"warnings", table.warnings},
      {"beside_published", summary},
      {"deviation_causes", table.causes},
      {"body", row_json(table, table.whole)},
      {"parts", parts}};
  return json_text(json, 1) + "\n";
}

Result<InertiaTable> table_from_json(const std::string& bytes, const std::string& where) {
  const auto json = parse_ordered_json(bytes, where);
  if (!json && where.ends_with(".csv"))
    return bad_use(where, "is the table as CSV; give the JSON file that `borelli inertia` writes beside it");
  if (!json) return tl::unexpected(json.error());
  try {
    return table_from(*json);
  } catch (const Json::exception&) {
    return failure(where,
                   "is not a complete inertia table: an entry has the wrong type; write the table again with "
                   "`borelli inertia`");
  } catch (const Damaged& damaged) {
    return failure(where, "is not a complete inertia table: " + damaged.what);
  }
}

Result<void> write_table(const std::filesystem::path& path, const InertiaTable& table) {
  const std::string extension = ending_of(path);
  if (extension != ".csv" && extension != ".json")
    return bad_use(path.string(), "is not a .csv or .json file; an inertia table is written as one of these");
  std::ofstream file(path, std::ios::binary);
  file << (extension == ".csv" ? to_csv(table) : to_json(table));
  file.close();
  if (!file)
    return failure(path.string(),
                   "cannot be written; check the folder, its permissions and the free disk space");
  return {};
}

Result<InertiaTable> read_table(const std::filesystem::path& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return table_from_json(*bytes, path.string());
}

}  // namespace borelli
