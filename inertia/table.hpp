// The inertia table: mass, gravity centre and inertia tensor of each part of a body, beside published values.
//
// Frames: the patient's axes in metres (x Left, y Posterior, z Superior; the world), and each segment's
// anatomical axes A, right-handed on both sides of the body: X anterior, Y proximal (superior in head and
// trunk), Z to the right (Wu et al (2002) J Biomech 35:543, (2005) 38:981); foot: X from heel to toe, Y up.
// So the products xz and yz of left and right limbs have opposite signs. Tensors are matrix entries, Ixy =
// -integral xy dm.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "inertia/anthropometry.hpp"
#include "inertia/inertial.hpp"

namespace borelli {

enum class Completeness {
  absent,  ///< not in the scan
  cut,     ///< the scan holds only a piece of it
  whole
};
std::string_view name_of(Completeness completeness);

/// Axes and endpoints of a segment; its length, cuts and percentages refer to them.
struct SegmentFrame {
  std::string segment;   ///< part without its side, e.g. "thigh"
  std::string from, to;  ///< endpoints by de Leva's names, e.g. "HJC" and "KJC"; empty: length unknown
  Eigen::Vector3d from_point = Eigen::Vector3d::Zero();  ///< m, patient axes
  Eigen::Vector3d to_point = Eigen::Vector3d::Zero();
  Eigen::Vector3d long_axis =
      Eigen::Vector3d::UnitZ();  ///< unit, patient axes, from the first towards the second endpoint
  Eigen::Matrix3d R_WA = Eigen::Matrix3d::Identity();  ///< columns: the anatomical axes, in the patient's
  std::string axes;                                    ///< how the axes were found, in words
  std::string cuts;  ///< as PublishedSegment::cuts, or other words for unpublished cuts
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< m, patient axes, if the frame has an origin
  std::string origin_name;                           ///< in words; empty: the frame has axes only

  /// The endpoints' distance along the long axis, m, as de Leva measures it; 0 if they are not known.
  double length() const { return from.empty() ? 0 : long_axis.dot(to_point - from_point); }
};

/// Standard deviation of an entry (see entries.hpp), by cause in the order of InertiaTable::causes.
struct EntryDeviation {
  std::string entry;
  double total = 0;
  std::vector<double> by_cause;
};

struct InertiaRow {
  std::string part;  ///< as in parts.hpp, e.g. "thigh_left"
  Completeness completeness = Completeness::whole;
  double volume = 0;  ///< m^3
  Inertial inertial;  ///< patient axes
  std::optional<SegmentFrame> frame;
  std::vector<std::string> notes;          ///< in plain words
  std::string flaw;                        ///< why no body can have this tensor; empty: one can
  std::vector<EntryDeviation> deviations;  ///< of each known entry; empty if none were requested
};

/// Origin of a table.
struct InertiaSource {
  std::string volume;          ///< file
  std::string quantity;        ///< quantity of the values, and why it was assumed
  std::string density_curve;   ///< name; empty: the values are densities
  std::string density_source;  ///< its publication
  std::string sampling;        ///< "points" or "averages", see moments.hpp
  std::string sex;             ///< "male", "female", or empty: not stated, no comparison
  std::string pose;            ///< "supine", "standing" ...; empty: not stated
  std::string cuts;            ///< convention of the cuts, e.g. "deleva1996"
  double stature_m = 0;        ///< 0: not known
  std::string frames;          ///< "joints" (segment_frames.hpp) or "isb" (isb_frames.hpp); empty: not stated
  std::string segments;        ///< requested segments ("trunk,thigh_left"); empty: every label
  std::string segmentation;    ///< its verdict, "good" or "doubtful: why"; empty: given labels
};

struct InertiaTable {
  InertiaSource source;
  std::vector<std::string> causes;  ///< causes of deviations, e.g. "noise"; empty: no deviations
  std::vector<InertiaRow> rows;
  /// All rows merged, as part "body"; whole if every row is. It describes the whole body even if single
  /// segments were requested.
  InertiaRow whole;
  std::vector<std::string> warnings{};  ///< from reading its inputs; doubts about the body

  /// Share of the mass of all rows, 0 to 1.
  double share(const InertiaRow& row) const { return row.inertial.mass / whole.inertial.mass; }
};

/// Sums the rows into `whole` and checks every tensor. An impossible tensor stays and gets a `flaw`.
InertiaTable make_table(InertiaSource source, std::vector<InertiaRow> rows);

/// A row's numbers that depend on its frame.
struct AnatomicalNumbers {
  Eigen::Matrix3d tensor;   ///< about the gravity centre, anatomical axes, kg m^2
  double length = 0;        ///< m; 0: unknown, and the two below are NaN
  double centre_along = 0;  ///< from the first endpoint along the long axis, over the length
  Eigen::Vector3d radii;    ///< of gyration about X, Y and Z, over the length
};
/// Empty for a row without a frame, or of an absent part.
std::optional<AnatomicalNumbers> anatomical_numbers(const InertiaRow& row);

/// A published row to compare with a measured one.
struct Comparison {
  const PublishedSegment* published = nullptr;
  bool mass = false;    ///< the mass share compares: the scan holds the whole body
  bool shape = false;   ///< gravity centre and radii compare: the endpoints are the same
  std::string why_not;  ///< what does not compare, and why; empty: all compares
};
/// Finds the row of a published table ("deleva1996" ...) with the same segment and cuts, for the table's sex.
/// Only whole parts compare. With other endpoints only the mass compares.
Comparison compare(const InertiaTable& table, const InertiaRow& row, std::string_view published_table);

}  // namespace borelli
