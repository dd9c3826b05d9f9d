#include "pipeline/verbs/state_file.hpp"

#include <fmt/core.h>

#include <cmath>

#include "dynamics/equations/evaluate.hpp"
#include "error/json_text.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

using nlohmann::json;

// A list of numbers under `key`, in the file's order; `standard` if it is missing.
Result<Eigen::VectorXd> list_of(const json& state, const std::string& file, const char* key,
                                const std::vector<Eigen::Index>& order, const Eigen::VectorXd& standard) {
  if (!state.contains(key)) return standard;
  const json& list = state.at(key);
  if (!list.is_array() || list.size() != order.size())
    return bad_use(
        file, fmt::format("{} is {}, expected a list of {} numbers", key, kind_of_json(list), order.size()));
  Eigen::VectorXd out(static_cast<Eigen::Index>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!list[i].is_number())
      return bad_use(file, fmt::format("{}[{}] is {}, expected a number", key, i, kind_of_json(list[i])));
    out[order[i]] = list[i].get<double>();
  }
  return out;
}

// Reads the state and the efforts.
Result<void> read_state(const std::string& file, SceneAtState& given) {
  const System& system = given.system;
  const FileOrder& order = given.order;
  const auto bytes = read_input_file(file);
  if (!bytes) return tl::unexpected(bytes.error());
  auto parsed = parse_json(*bytes, file);
  if (!parsed) return bad_use(parsed.error().where, parsed.error().what);
  const json& state = *parsed;
  if (!state.is_object())
    return bad_use(file,
                   fmt::format(R"(is {}, expected {{"t": 0, "q": [...], "v": [...], "efforts": [...]}})",
                               kind_of_json(state)));
  for (const auto& [key, value] : state.items())
    if (key != "t" && key != "q" && key != "v" && key != "efforts")
      return bad_use(file, fmt::format("unknown key '{}'; known: t, q, v, efforts", key));
  if (state.contains("t") && !state.at("t").is_number())
    return bad_use(file, fmt::format("t is {}, expected a number", kind_of_json(state.at("t"))));
  if (!state.contains("q") && system.nq > 0)
    return bad_use(file, fmt::format("q is missing, expected a list of {} numbers", system.nq));

  given.state.t = state.value("t", 0.0);
  auto q = list_of(state, file, "q", order.q, given.state.q);
  auto v = list_of(state, file, "v", order.v, Eigen::VectorXd::Zero(system.nv));
  auto efforts = list_of(state, file, "efforts", order.v, given.efforts);
  for (const auto* list : {&q, &v, &efforts})
    if (!*list) return tl::unexpected(list->error());
  given.state.q = *q, given.state.v = *v, given.efforts = *efforts;
  return {};
}

// Name of the first non-finite number in it; "" if there is none.
std::string no_number(const json& value, const std::string& name) {
  if (value.is_number_float()) return std::isfinite(value.get<double>()) ? "" : name;
  if (!value.is_structured()) return "";
  for (const auto& entry : value.items()) {
    const json& part = entry.value();
    if (part.is_number_float() && std::isfinite(part.get<double>())) continue;
    const std::string own = value.is_array() ? fmt::format("{}[{}]", name, entry.key())
                            : name.empty()   ? entry.key()
                                             : name + "." + entry.key();
    if (const std::string found = no_number(part, own); !found.empty()) return found;
  }
  return "";
}

}  // namespace

Result<json> of_numbers(const StateOptions& o, json answer) {
  if (const std::string name = no_number(answer, ""); !name.empty())
    return failure(
        o.scene,
        fmt::format(
            "{} is not a finite number at this state; the state or a number of the scene is too large",
            name));
  return answer;
}

void add_state_options(CLI::App& verb, StateOptions& o) {
  verb.add_option("scene", o.scene, "Scene file: TOML, MJCF, URDF or OpenSim")->required();
  verb.add_option("--state", o.state,
                  "JSON file with t (s), q, v and efforts in the order of the scene's file, as `end` in the "
                  "answer of `simulate --json`; q is required, a missing t, v or efforts is zero (default: "
                  "the scene's initial state)")
      ->type_name("FILE");
  add_shared(verb, flags::equations, o.equations, " (default: the scene's)");
  add_model_options(verb, o.model);
}

Result<SceneAtState> read_scene_at_state(const StateOptions& o, const Command& command) {
  auto model = read_model(command, o.scene, o.model);
  if (!model) return tl::unexpected(model.error());
  auto system = compile(model->scene);
  if (!system) return in_file(o.scene, system.error());
  if (o.equations)
    system->settings.equations = *o.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  SceneAtState out{std::move(*model), std::move(*system), {}, {}, {}};
  out.order = file_order(out.model.scene, out.system.coordinates);
  out.state = out.system.initial;
  out.efforts = Eigen::VectorXd::Zero(out.system.nv);
  if (!o.state.empty())
    if (const auto read = read_state(o.state, out); !read) return tl::unexpected(read.error());
  if (const auto fits = check_state(out.system, out.state); !fits)
    return bad_use(o.state.empty() ? o.scene : o.state, fits.error().message());
  return out;
}

json json_of(const State& state, const FileOrder& order) {
  return {{"t", state.t}, {"q", in_file_order(state.q, order.q)}, {"v", in_file_order(state.v, order.v)}};
}

json rows_in_file_order(const Eigen::MatrixXd& rows, const FileOrder& order) {
  json out = json::array();
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    out.push_back(in_file_order(rows.row(r).transpose(), order.v));
  return out;
}

}  // namespace borelli
