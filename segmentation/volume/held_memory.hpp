// Tunes the heap for programs that work on volumes.
#pragma once

#include <cstddef>

namespace borelli {

/// Keeps freed memory in the process, up to 1.5 GB. Call it first in main. Segmentation allocates and frees
/// dozens of volumes. Memory returned to the system would have to be mapped and zeroed again for each. The
/// first 1 GB is requested in huge pages (2 MB, mapped when first touched). All threads share one heap,
/// because glibc maps large blocks anew for a thread's own heap. Does nothing without glibc.
void hold_freed_memory();

/// Announces that about `bytes` more than now will be in use. A low-priority background thread then maps that
/// much of the held memory ahead of time. On virtual machines whose host provides pages at first touch,
/// mapping can take a third of the run time. Does nothing if hold_freed_memory was not called or no thread
/// can be started.
void map_ahead(std::size_t bytes);

}  // namespace borelli
