// The convention by which a body is cut into parts. Segment masses compare only within one convention.
//
//   deleva1996   the planes of Zatsiorsky and Seluyanov as de Leva (1996) uses them
//   dempster     the planes of Dempster (1955), approximated by Winter's endpoints
//   bone         no planes: each voxel belongs to the part of the bone that its flesh surrounds
// cuts.hpp lists every plane.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

enum class Convention { deleva1996, dempster, bone };

inline constexpr std::array<Convention, 3> conventions{Convention::deleva1996, Convention::dempster,
                                                       Convention::bone};

std::string_view name_of(Convention convention);

/// The convention with this name. Error: unknown name; the message lists the known ones.
Result<Convention> convention(std::string_view name);

/// The landmark that bounds the part beyond a joint (as in parts.hpp). With planes, the landmark that defines
/// the joint's plane, e.g. "asis_left" for "hip_left" with deleva1996. With `bone`, the landmark at which the
/// two bones separate.
std::string bound_of(std::string_view joint, Convention convention);

}  // namespace borelli
