// By which convention a body is cut into parts: named, as masses of segments compare only within one.
//
//   deleva1996   the planes of Zatsiorsky and Seluyanov as de Leva (1996) uses them
//   dempster     the planes of Dempster (1955) as far as Winter's endpoints tell them
//   bone         no planes: each voxel follows the bone that its flesh hangs on
// cuts.hpp writes every plane out.
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

/// By its name. Error: no such convention, naming those that there are.
Result<Convention> convention(std::string_view name);

/// The landmark that bounds the part beyond a joint (as in parts.hpp): the one that the joint's plane hangs
/// on, e.g. "asis_left" of "hip_left" with deleva1996; with `bone` the one that its bones part at.
std::string bound_of(std::string_view joint, Convention convention);

}  // namespace borelli
