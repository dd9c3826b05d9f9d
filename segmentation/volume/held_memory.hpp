// Memory for programs that work on volumes.
#pragma once

#include <cstddef>

namespace borelli {

/// To be called first in a program's main. Volumes come and go by the dozen while parts are found; memory
/// that goes back to the system with each has to be mapped and cleared again for the next. So freed memory is
/// held on to, up to 1.5 GB; the first of it is asked for in huge pages (2 MB, mapped when first touched);
/// and all threads share one heap, since glibc maps anew what is too large for a thread's own. Nothing
/// without glibc.
void hold_freed_memory();

/// Says that about as many bytes more than now will be in use at a time: what is held on to is mapped that
/// far in the meantime, by a thread that others go before. On virtual machines whose host hands out pages
/// when they are first touched that takes as long as a third of the work. Nothing where hold_freed_memory was
/// not called, or no thread can be had.
void map_ahead(std::size_t bytes);

}  // namespace borelli
