// Published inertia of body segments, for comparison with measured ones.
//
//   deleva1996   de Leva P (1996) J Biomech 29:1223-1230: Zatsiorsky and Seluyanov's gamma-ray scans of
//                living people, lying, with their endpoints moved to joint centres
//   zatsiorsky2002  means of Zatsiorsky and Seluyanov (Zatsiorsky V M (2002) Kinetics of Human Motion);
//                masses only, since the endpoints of the other numbers are not named
//   winter2009   Dempster's cadavers (1955) as given by Winter D A (2009), men and women alike
//   dumas2007    Dumas R, Cheze L, Verriest J-P (2007) J Biomech 40:543-553: McConville's and Young's body
//                surfaces of standing people, of uniform density; with products of inertia
// Two values compare only if endpoints and kind of cuts agree: moving the hip's cut alone changes a thigh
// from 8 to 14 % of body mass. Below elbow and knee both studies cut across the limb at its joints ("joint"),
// but each by its own landmarks. There the tables differ from each other by up to 0.5 % of body mass, and
// measured values may differ from either by as much.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// Mean of one sex. Axes: X anterior, Y proximal (superior in the trunk), Z right; foot: X from heel to toe,
/// Y up. Numbers that a table does not give are NaN.
struct PublishedSegment {
  std::string table;      ///< "deleva1996", "dumas2007", "winter2009" or "zatsiorsky2002"
  std::string sex;        ///< "male", "female" or "any"
  std::string segment;    ///< as in parts.hpp without the side ("thigh"); also "trunk", "torso", "pelvis"
  std::string from, to;   ///< endpoints, de Leva's names, e.g. "HJC" and "KJC"; empty: not named
  std::string cuts;       ///< "joint", "zatsiorsky", "mcconville" or "dempster", see the data files' headers
  double mass_share = 0;  ///< of body mass
  double centre_along = 0;  ///< gravity centre from the first endpoint towards the second, of their distance
  Eigen::Vector3d radii;    ///< of gyration about X, Y and Z through the gravity centre, of the same distance
  Eigen::Vector3d
      products;  ///< xy, xz, yz: an entry of the inertia matrix is sign(r) m (r L)^2; NaN where not given
  double length = 0;  ///< mean of the endpoints' distance along the long axis, m; NaN where not given
};

/// All rows of all tables, from inertia/data.
const std::vector<PublishedSegment>& published_segments();

/// The row of a table with these endpoints and cuts, for this sex or "any"; nullptr if there is none. With
/// `from` and `to` empty: the first row with such cuts, whatever its endpoints, for comparing masses.
const PublishedSegment* published_segment(std::string_view table, std::string_view sex,
                                          std::string_view segment, std::string_view from,
                                          std::string_view to, std::string_view cuts);

}  // namespace borelli
