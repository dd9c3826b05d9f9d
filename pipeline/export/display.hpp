// Whether there is a screen to draw with: VTK renders only under an X display, also unseen.
#pragma once

namespace borelli {

/// Whether the display named by the environment answers; half a second is waited for one that does not. From
/// then on the process keeps a connection to it. VTK aborts the process where no display answers. Call it
/// from one thread.
bool display_answers();

}  // namespace borelli
