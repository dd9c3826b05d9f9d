#include "pipeline/verbs/inputs.hpp"

#include <filesystem>

#include "inertia/table_file.hpp"

namespace borelli {
namespace {

// Passes the reader's warnings on to the Command.
template <class T>
Result<T> pass_warnings(const Command& command, Result<T> read) {
  if (read) command.warn(read->warnings);
  return read;
}

}  // namespace

Result<ScannedVolume> read_volume(const Command& command, const std::string& path,
                                  const std::string& quantity, const Progress& progress) {
  ReadOptions options{.progress = progress};
  if (!quantity.empty()) {
    const auto parsed = parse_quantity(quantity);
    if (!parsed) return tl::unexpected(parsed.error());
    options.quantity = *parsed;
  }
  return pass_warnings(command, read_volume(path, options));
}

Result<LabelMap> read_labels(const Command& command, const std::string& path, const std::string& names,
                             const Grid* scan) {
  auto labels = read_labels(path, names, {}, scan);
  if (labels)
    for (const std::string& warning : labels->warnings) command.warn(path + ": " + warning);
  return labels;
}

Result<ClassLabels> read_classes(const Command& command, const std::string& path, const std::string& names,
                                 const std::string& mapping, const GreyVolume& scan) {
  return pass_warnings(command, read_classes(path, names, mapping, &scan));
}

Result<GivenLandmarks> read_given_landmarks(const Command& command, const std::string& path) {
  if (path.empty()) return GivenLandmarks();
  return pass_warnings(command, read_given_landmarks(path));
}

Result<InertiaTable> read_table(const Command& command, const std::string& path) {
  auto table = read_table(std::filesystem::path(path));
  if (table)
    for (const std::string& warning : table->warnings) command.warn(path + ": " + warning);
  return table;
}

Result<ModelFile> read_model(const Command& command, const std::string& path, const ModelOptions& options) {
  auto model = read_model(std::filesystem::path(path), options);
  if (!model || model->not_modelled.empty()) return model;
  const auto& [motion, other] = model->not_modelled;
  for (const std::string& line : motion) command.warn("not modelled, so the motion differs: " + line);
  for (const std::string& line : other) command.note("not modelled: " + line);
  command.add_to_answer("not_modelled", {{"changes_motion", motion}, {"other", other}});
  return model;
}

Result<ModelFile> read_model_for_pages(const Command& command, const std::string& path,
                                       const ModelOptions& options) {
  auto model = read_model(command, path, options);
  if (!model) return model;
  Scene& scene = model->scene;
  scene.file = command.names().name_of(path);
  if (scene.name.empty()) scene.name = scene.file;
  return model;
}

tl::unexpected<Error> in_file(const std::string& file, Error error) {
  if (!error.where.starts_with(file)) error.where = error.where.empty() ? file : file + ", " + error.where;
  return tl::unexpected(std::move(error));
}

}  // namespace borelli
