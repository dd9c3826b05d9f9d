// The scene of a file and the system compiled from it, as Python holds them.
#pragma once

#include <memory>
#include <string>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/system/system.hpp"

namespace borelli::python {

/// A compiled scene. Both are constant, so any number of threads may use them.
struct CompiledScene {
  std::shared_ptr<const ModelFile> model;
  System system;
};

/// Compiles a scene; throws Failure.
std::shared_ptr<const CompiledScene> compiled(std::shared_ptr<const ModelFile> model);

}  // namespace borelli::python
