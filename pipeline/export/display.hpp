// Tells whether an X display is available: VTK needs one even for off-screen rendering.
#pragma once

namespace borelli {

/// Whether the display named by the environment answers within half a second. The process then keeps a
/// connection to it. Call this before VTK, which aborts the process if no display answers. Call it from one
/// thread.
bool display_answers();

}  // namespace borelli
