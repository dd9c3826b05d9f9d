#include "inertia/anthropometry.hpp"

#include <limits>

#include "inertia/csv.hpp"

namespace borelli {
namespace data {
extern const char* const deleva1996;
extern const char* const dumas2007;
extern const char* const winter2009;
extern const char* const zatsiorsky2002;
}  // namespace data
namespace {

constexpr double percent = 0.01, mm = 1e-3, none = std::numeric_limits<double>::quiet_NaN();

PublishedSegment names(std::string table_name, const CsvTable& table, std::size_t row) {
  PublishedSegment segment;
  segment.table = std::move(table_name);
  segment.sex = table.field(row, "sex");
  segment.segment = table.field(row, "segment");
  segment.from = table.field(row, "from");
  segment.to = table.field(row, "to");
  segment.cuts = table.field(row, "cuts");
  segment.mass_share = percent * table.number(row, "mass_pct");
  return segment;
}

void add_deleva(std::vector<PublishedSegment>& list) {
  const CsvTable table = parse_csv(data::deleva1996, "deleva1996.csv").value();
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    PublishedSegment segment = names("deleva1996", table, row);
    segment.centre_along = percent * table.number(row, "centre_pct");
    const double sagittal = percent * table.number(row, "sagittal_pct");
    const double transverse = percent * table.number(row, "transverse_pct");
    const double longitudinal = percent * table.number(row, "longitudinal_pct");
    // a foot's long axis is our X; its sagittal axis, along the sole's normal, is our Y
    segment.radii = segment.segment == "foot" ? Eigen::Vector3d(longitudinal, sagittal, transverse)
                                              : Eigen::Vector3d(sagittal, longitudinal, transverse);
    segment.products.setConstant(none);
    segment.length = mm * table.number(row, "length_mm");
    list.push_back(segment);
  }
}

// position of the centre between the endpoints, 0 to 1, along the axis that joins them
double along(const PublishedSegment& segment, const Eigen::Vector3d& centre) {
  if (segment.from == "CAL") return centre[0];
  if (segment.segment == "head") return centre[1];
  const bool downwards = segment.segment != "foot" && segment.from != "SUP" && segment.from != "midASIS";
  return downwards ? -centre[1] : none;
}

void add_dumas(std::vector<PublishedSegment>& list) {
  const CsvTable table = parse_csv(data::dumas2007, "dumas2007.csv").value();
  const auto three = [&](std::size_t row, const char* x, const char* y, const char* z) {
    return Eigen::Vector3d(percent *
                           Eigen::Vector3d(table.number(row, x), table.number(row, y), table.number(row, z)));
  };
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    PublishedSegment segment = names("dumas2007", table, row);
    segment.centre_along = along(segment, three(row, "centre_x_pct", "centre_y_pct", "centre_z_pct"));
    segment.radii = three(row, "rxx_pct", "ryy_pct", "rzz_pct");
    segment.products = three(row, "rxy_pct", "rxz_pct", "ryz_pct");
    segment.length = none;
    list.push_back(segment);
  }
}

void add_winter(std::vector<PublishedSegment>& list) {
  const CsvTable table = parse_csv(data::winter2009, "winter2009.csv").value();
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    PublishedSegment segment = names("winter2009", table, row);
    segment.sex = "any";
    segment.centre_along = percent * table.number(row, "centre_pct");
    segment.radii = Eigen::Vector3d(none, none, percent * table.number(row, "gyration_c_pct"));
    segment.products.setConstant(none);
    segment.length = none;
    list.push_back(segment);
  }
}

void add_zatsiorsky(std::vector<PublishedSegment>& list) {
  const CsvTable table = parse_csv(data::zatsiorsky2002, "zatsiorsky2002.csv").value();
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    PublishedSegment segment = names("zatsiorsky2002", table, row);
    segment.centre_along = segment.length = none;
    segment.radii.setConstant(none), segment.products.setConstant(none);
    list.push_back(segment);
  }
}

}  // namespace

const std::vector<PublishedSegment>& published_segments() {
  static const auto segments = [] {
    std::vector<PublishedSegment> list;
    add_deleva(list);
    add_dumas(list);
    add_winter(list);
    add_zatsiorsky(list);
    return list;
  }();
  return segments;
}

const PublishedSegment* published_segment(std::string_view table, std::string_view sex,
                                          std::string_view segment, std::string_view from,
                                          std::string_view to, std::string_view cuts) {
  for (const auto& row : published_segments())
    if (row.table == table && (row.sex == sex || row.sex == "any") && row.segment == segment &&
        ((row.from == from && row.to == to) || (from.empty() && to.empty())) && row.cuts == cuts)
      return &row;
  return nullptr;
}

}  // namespace borelli
