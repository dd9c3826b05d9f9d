// Scenes of the paper that this engine follows (Gillard, Nourrit, Lucas, Remion: A generic algorithm for the
// generation of physical movements of solid systems). The paper gives no masses; ours are in the scenes'
// files.
#pragma once

#include "dynamics/scene/scene.hpp"

namespace borelli {

/// Figure 1: a turntable with two hanging arms (samples/roundabout.toml).
Scene roundabout();

/// Figure 5: a falling cube stopped by a bar in a slide (samples/shock.toml).
Scene shock();

/// Figure 10: n bars side by side, each on its own hinge; all start level (samples/bars_<n>.toml). Each bar
/// has 1 kg and 1 m. The hinges turn about y, 2 m apart along x. 10 s.
Scene bars(int n);

/// Figure 10: the same n bars in a chain, an n-pendulum (samples/pendulum_<n>.toml). All start level, in one
/// line. 10 s.
Scene pendulum(int n);

}  // namespace borelli
