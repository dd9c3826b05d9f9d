#include "segmentation/vocabulary/convention.hpp"

#include <fmt/core.h>

namespace borelli {

std::string_view name_of(Convention convention) {
  switch (convention) {
    case Convention::deleva1996:
      return "deleva1996";
    case Convention::dempster:
      return "dempster";
    case Convention::bone:
      break;
  }
  return "bone";
}

Result<Convention> convention(std::string_view name) {
  for (const Convention known : conventions)
    if (name == name_of(known)) return known;
  return bad_use("convention",
                 fmt::format("unknown convention '{}'; choose deleva1996, dempster or bone", name));
}

std::string bound_of(std::string_view joint, Convention convention) {
  if (convention == Convention::deleva1996) {
    if (joint == "spine_upper") return "xiphion";
    if (joint == "spine_lower") return "omphalion";
    if (joint.starts_with("hip")) return "asis" + std::string(joint.substr(3));
  }
  if (joint == "spine_upper") return "t12_l1";
  if (joint == "spine_lower") return convention == Convention::bone ? "l5_s1" : "l4_l5";
  return std::string(joint);
}

}  // namespace borelli
