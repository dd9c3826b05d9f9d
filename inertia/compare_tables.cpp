#include "inertia/compare_tables.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "error/json_text.hpp"
#include "inertia/csv.hpp"
#include "inertia/entries.hpp"

namespace borelli {
namespace {

using Json = nlohmann::ordered_json;

const InertiaRow* row_of(const InertiaTable& table, const std::string& part) {
  if (part == table.whole.part) return &table.whole;
  for (const InertiaRow& row : table.rows)
    if (row.part == part) return &row;
  return nullptr;
}

// parts in the order of the tables, the whole body last
std::vector<std::string> parts_of(const std::vector<const InertiaTable*>& tables) {
  std::vector<std::string> names;
  for (const InertiaTable* table : tables)
    for (const InertiaRow& row : table->rows)
      if (std::ranges::find(names, row.part) == names.end()) names.push_back(row.part);
  names.push_back("body");
  return names;
}

// one body's numbers; NaN if the part is not whole
std::vector<Entry> numbers_of(const InertiaTable& table, const std::string& part) {
  const InertiaRow* row = row_of(table, part);
  std::vector<Entry> entries =
      entries_of(table, row ? *row : InertiaRow{.completeness = Completeness::absent});
  for (Entry& entry : entries)
    if (!row || row->completeness != Completeness::whole) entry.value = std::nan("");
  // the whole body's share of itself is meaningless
  if (row == &table.whole)
    for (Entry& entry : entries)
      if (entry.name == "mass_pct") entry.value = std::nan("");
  // a part's share of an incomplete body is meaningless
  if (table.whole.completeness != Completeness::whole)
    for (Entry& entry : entries)
      if (entry.name == "mass_pct") entry.value = std::nan("");
  return entries;
}

std::optional<double> deviation_of(const InertiaTable& table, const std::string& part,
                                   const std::string& entry) {
  const InertiaRow* row = row_of(table, part);
  if (!row) return std::nullopt;
  for (const EntryDeviation& deviation : row->deviations)
    if (deviation.entry == entry) return deviation.total;
  return std::nullopt;
}

struct Predictors {
  Eigen::MatrixXd rows;  // 1, stature, mass of each table that has both
  std::vector<std::size_t> tables;
  std::string why_not;
};

Predictors predictors_of(const std::vector<NamedTable>& tables) {
  Predictors predictors;
  for (std::size_t n = 0; n < tables.size(); ++n) {
    const InertiaTable& table = tables[n].table;
    if (table.source.stature_m > 0 && table.whole.completeness == Completeness::whole)
      predictors.tables.push_back(n);
  }
  if (predictors.tables.size() < 5) {
    predictors.why_not = fmt::format(
        "a regression on stature and mass needs five whole bodies with a stature (borelli inertia "
        "--stature); {} of {} qualify",
        predictors.tables.size(), tables.size());
    return predictors;
  }
  predictors.rows.resize(static_cast<Eigen::Index>(predictors.tables.size()), 3);
  for (std::size_t n = 0; n < predictors.tables.size(); ++n) {
    const InertiaTable& table = tables[predictors.tables[n]].table;
    predictors.rows.row(static_cast<Eigen::Index>(n)) << 1, table.source.stature_m, table.whole.inertial.mass;
  }
  // scaled by their spread, so that the rank does not depend on kilograms and metres
  Eigen::MatrixXd centred =
      predictors.rows.rightCols(2).rowwise() - predictors.rows.rightCols(2).colwise().mean();
  for (Eigen::Index c = 0; c < 2; ++c)
    if (const double size = centred.col(c).norm(); size > 1e-6) centred.col(c) /= size;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(centred);
  qr.setThreshold(1e-3);
  if (qr.rank() < 2)
    predictors.why_not = "stature and mass vary only together in these bodies, so there is no regression";
  return predictors;
}

std::optional<TableRegression> regression_of(const Predictors& predictors,
                                             const std::vector<double>& values) {
  std::vector<Eigen::Index> known;
  for (std::size_t n = 0; n < predictors.tables.size(); ++n)
    if (std::isfinite(values[predictors.tables[n]])) known.push_back(static_cast<Eigen::Index>(n));
  if (known.size() < 5) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(known.size());
  Eigen::MatrixXd X(n, 3);
  Eigen::VectorXd y(n);
  for (Eigen::Index r = 0; r < n; ++r) {
    const Eigen::Index from = known[static_cast<std::size_t>(r)];
    X.row(r) = predictors.rows.row(from);
    y[r] = values[predictors.tables[static_cast<std::size_t>(from)]];
  }
  const Eigen::Vector3d b = X.colPivHouseholderQr().solve(y);
  const double left = (y - X * b).squaredNorm(), all = (y.array() - y.mean()).square().sum();
  return TableRegression{static_cast<int>(n),
                         b[0],
                         b[1],
                         b[2],
                         all > 0 ? 1 - left / all : 0,
                         std::sqrt(left / static_cast<double>(n - 3))};
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : ""; }

std::string heading(const std::vector<NamedTable>& tables) {
  std::string text = "# borelli comparison of inertia tables, 1\n";
  for (std::size_t n = 0; n < tables.size(); ++n)
    text += fmt::format("# table {}: {}\n", n + 1, tables[n].name);
  const InertiaSource& source = tables.front().table.source;
  text += fmt::format("# cuts: {}; frames: {}\n", source.cuts, source.frames);
  for (const std::string& remark : remarks_on(tables)) text += "# " + remark + "\n";
  return text;
}

/// Whether two tables are copies: two measurements never agree to the last digit.
bool same_numbers(const InertiaTable& a, const InertiaTable& b) {
  return std::ranges::equal(a.rows, b.rows, [](const InertiaRow& p, const InertiaRow& q) {
    return p.part == q.part && p.inertial.mass == q.inertial.mass && p.inertial.centre == q.inertial.centre &&
           p.inertial.tensor == q.inertial.tensor;
  });
}

}  // namespace

Result<void> check_comparable(const std::vector<NamedTable>& tables) {
  if (tables.size() < 2) return bad_use("--compare", "needs two or more tables");
  const NamedTable& first = tables.front();
  for (const NamedTable& other : tables) {
    const auto differ = [&](const char* what, const std::string& a, const std::string& b) {
      return bad_use(
          other.name,
          fmt::format("its {0} follow {1}, those of {2} follow {3}; parts are comparable only with "
                      "the same cuts and frames; make both tables with the same --convention and "
                      "--frames",
                      what, b.empty() ? "an unstated method" : b, first.name,
                      a.empty() ? "an unstated method" : a));
    };
    if (other.table.source.cuts != first.table.source.cuts)
      return differ("cuts", first.table.source.cuts, other.table.source.cuts);
    if (other.table.source.frames != first.table.source.frames)
      return differ("frames", first.table.source.frames, other.table.source.frames);
  }
  return {};
}

std::vector<std::string> remarks_on(const std::vector<NamedTable>& tables) {
  const auto distinct = [&](auto field) {
    std::set<std::string> values;
    for (const NamedTable& named : tables) {
      const std::string value = named.table.source.*field;
      values.insert(value.empty() ? "not stated" : value);
    }
    return values;
  };
  std::vector<std::string> remarks;
  const auto curves = distinct(&InertiaSource::density_curve), poses = distinct(&InertiaSource::pose),
             sexes = distinct(&InertiaSource::sex);
  if (curves.size() > 1) remarks.push_back(fmt::format("density curves differ: {}", fmt::join(curves, ", ")));
  if (poses.size() > 1)
    remarks.push_back(
        fmt::format("poses differ: {}; soft tissue shifts with the pose", fmt::join(poses, ", ")));
  if (sexes.size() > 1) remarks.push_back(fmt::format("sexes differ: {}", fmt::join(sexes, ", ")));
  for (std::size_t i = 0; i < tables.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_numbers(tables[i].table, tables[j].table))
        remarks.push_back(
            fmt::format("tables {} ({}) and {} ({}) contain the same numbers, so one body counts twice",
                        j + 1, tables[j].name, i + 1, tables[i].name));
  return remarks;
}

std::vector<TableDifference> differences(const InertiaTable& first, const InertiaTable& second) {
  std::vector<TableDifference> all;
  for (const std::string& part : parts_of({&first, &second})) {
    const auto a = numbers_of(first, part), b = numbers_of(second, part);
    for (std::size_t n = 0; n < a.size(); ++n) {
      if (!a[n].of_the_body || !std::isfinite(a[n].value) || !std::isfinite(b[n].value)) continue;
      TableDifference difference{part, a[n].name, a[n].value, b[n].value, {}};
      const auto da = deviation_of(first, part, a[n].name), db = deviation_of(second, part, a[n].name);
      if (da && db && std::hypot(*da, *db) > 0) difference.deviation = std::hypot(*da, *db);
      all.push_back(std::move(difference));
    }
  }
  return all;
}

GroupTable group_of(const std::vector<NamedTable>& tables) {
  GroupTable group;
  const Predictors predictors = predictors_of(tables);
  group.no_regression = predictors.why_not;
  std::vector<const InertiaTable*> all;
  for (const NamedTable& named : tables) all.push_back(&named.table);
  for (const std::string& part : parts_of(all)) {
    std::vector<std::vector<Entry>> numbers;
    for (const InertiaTable* table : all) numbers.push_back(numbers_of(*table, part));
    for (std::size_t e = 0; e < numbers.front().size(); ++e) {
      if (!numbers.front()[e].of_the_body) continue;
      GroupEntry entry;
      entry.part = part, entry.entry = numbers.front()[e].name;
      std::vector<double> values;
      for (const auto& of_one : numbers) {
        values.push_back(of_one[e].value);
        if (std::isfinite(values.back())) ++entry.bodies, entry.mean += values.back();
      }
      if (entry.bodies == 0) continue;
      entry.mean /= entry.bodies;
      for (const double value : values)
        if (std::isfinite(value)) entry.sd += (value - entry.mean) * (value - entry.mean);
      entry.sd = entry.bodies > 1 ? std::sqrt(entry.sd / (entry.bodies - 1)) : std::nan("");
      const bool predictor = part == "body" && entry.entry == "mass_kg";
      if (predictors.why_not.empty() && !predictor) entry.regression = regression_of(predictors, values);
      group.entries.push_back(std::move(entry));
    }
  }
  return group;
}

std::string comparison_csv(const std::vector<NamedTable>& tables) {
  std::string text = heading(tables);
  if (tables.size() == 2) {
    text += "# difference: table 2 - table 1; sd: its standard deviation; in_sds: difference / sd\n";
    text += "part,entry,first,second,difference,percent,sd,in_sds\n";
    for (const auto& d : differences(tables[0].table, tables[1].table)) {
      const double off = d.second - d.first;
      text +=
          fmt::format("{},{},{},{},{},{},{},{}\n", csv_field(d.part), d.entry, number(d.first),
                      number(d.second), number(off), number(d.percent()),
                      d.deviation ? number(*d.deviation) : "", d.deviation ? number(off / *d.deviation) : "");
    }
    return text;
  }
  const GroupTable group = group_of(tables);
  if (!group.no_regression.empty()) text += "# " + group.no_regression + "\n";
  text += "# regression: entry = intercept + per_metre stature + per_kilogram mass; residual_sd: about it\n";
  text += "part,entry,bodies,mean,sd,regression_bodies,intercept,per_metre,per_kilogram,r2,residual_sd\n";
  for (const GroupEntry& e : group.entries) {
    text += fmt::format("{},{},{},{},{}", csv_field(e.part), e.entry, e.bodies, number(e.mean), number(e.sd));
    if (const auto& r = e.regression)
      text += fmt::format(",{},{},{},{},{},{}\n", r->bodies, number(r->intercept), number(r->per_metre),
                          number(r->per_kilogram), number(r->r2), number(r->residual_sd));
    else
      text += ",,,,,,\n";
  }
  return text;
}

std::string comparison_json(const std::vector<NamedTable>& tables) {
  const auto finite = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  Json json{{"format", "borelli comparison of inertia tables, 1"}};
  for (const NamedTable& named : tables)
    json["tables"].push_back(
        {{"name", named.name},
         {"mass_kg", named.table.whole.inertial.mass},
         {"stature_m", named.table.source.stature_m > 0 ? Json(named.table.source.stature_m) : Json()}});
  json["cuts"] = tables.front().table.source.cuts;
  json["frames"] = tables.front().table.source.frames;
  json["remarks"] = remarks_on(tables);
  if (tables.size() == 2) {
    json["differences"] = Json::array();
    for (const auto& d : differences(tables[0].table, tables[1].table)) {
      Json one{{"part", d.part},
               {"entry", d.entry},
               {"first", d.first},
               {"second", d.second},
               {"difference", d.second - d.first},
               {"percent", finite(d.percent())}};
      if (d.deviation) one["sd"] = *d.deviation, one["in_sds"] = finite((d.second - d.first) / *d.deviation);
      json["differences"].push_back(one);
    }
    return json_text(json, 1) + "\n";
  }
  const GroupTable group = group_of(tables);
  if (!group.no_regression.empty()) json["no_regression"] = group.no_regression;
  json["group"] = Json::array();
  for (const GroupEntry& e : group.entries) {
    Json one{
        {"part", e.part}, {"entry", e.entry}, {"bodies", e.bodies}, {"mean", e.mean}, {"sd", finite(e.sd)}};
    if (const auto& r = e.regression)
      one["regression"] = {{"bodies", r->bodies},
                           {"intercept", r->intercept},
                           {"per_metre", r->per_metre},
                           {"per_kilogram", r->per_kilogram},
                           {"r2", r->r2},
                           {"residual_sd", r->residual_sd}};
    json["group"].push_back(one);
  }
  return json_text(json, 1) + "\n";
}

}  // namespace borelli
