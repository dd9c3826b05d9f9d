#include "process/on_demand.hpp"

#include <dlfcn.h>

namespace borelli {

Result<const void*> load_on_demand(const char* library) {
  const std::string file = std::string(library) + "-" BORELLI_VERSION ".so";
  void* const loaded = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  const void* const table = loaded ? dlsym(loaded, "borelli_functions") : nullptr;
  if (table) return table;
  const char* const why = dlerror();
  return failure(file, std::string("cannot be loaded; install the program again (") + (why ? why : "") + ")");
}

}  // namespace borelli
