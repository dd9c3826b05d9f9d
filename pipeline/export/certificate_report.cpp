#include "pipeline/export/certificate_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/run/step_watch.hpp"
#include "pipeline/export/certificate_fields.hpp"

namespace borelli {

namespace {

// With fixed steps there is no smallest step, but the certificate then stores its first.
std::string smallest_step(const Certificate& c) {
  if (c.steps_accepted == 0) return "";
  if (c.smallest_step_time == 0)
    return fmt::format("; none was smaller than the first, {:.3g} s", c.smallest_step);
  return fmt::format("; the smallest was {:.3g} s (at {:.6g} s)", c.smallest_step, c.smallest_step_time);
}

std::string shock_of(const LoggedEvent& e) {
  if (e.impulse == 0) return "";
  return fmt::format(" (impulse {:.6g}, {:.6g} J lost)", e.impulse, e.energy_lost);
}

template <class Row>
nlohmann::json table_of(const std::vector<Row>& rows) {
  auto table = nlohmann::json::array();
  for (const Row& row : rows) {
    auto& entry = table.emplace_back();
    visit_columns(&row,
                  [&](const char* name, auto field, const char*, Presence) { entry[name] = row.*field; });
  }
  return table;
}

}  // namespace

std::string text_of(const Certificate& c) {
  if (c.method == captured_method) return "recorded, not computed: nothing to trust or distrust\n";
  std::string out = c.trusted ? "trusted\n" : fmt::format("UNTRUSTED: {}\n", c.reason);
  const auto line = [&](const std::string& text) { out += text + '\n'; };
  line("vouches for " + vouches_for(c));
  const double share = c.energy_turnover > 0 ? c.energy_drift / c.energy_turnover : 0;
  line(fmt::format(
      "energy: drifts by at most {:.3g} J (at {:.6g} s), {:.2g} of the {:.4g} J turned over; trusted up to "
      "{:.2g}",
      c.energy_drift, c.energy_drift_time, share, c.energy_turnover, c.energy_threshold));
  const std::pair<const char*, double> works[] = {
      {"forces and dampers", c.work_efforts},     {"driven coordinates", c.work_drives},
      {"moving constraints", c.work_constraints}, {"constraint errors", c.work_baumgarte},
      {"projection", c.work_projection},          {"events", c.work_events}};
  for (const auto& [name, work] : works)
    if (work != 0) line(fmt::format("work of {}: {:.6g} J", name, work));
  if (c.impacts > 0) line(fmt::format("impacts: {}, in which {:.6g} J were lost", c.impacts, c.impact_loss));
  if (c.contact_error > 0)
    line(fmt::format("contacts within steps: spurious work of at most {:.3g} J", c.contact_error));
  for (const Conserved& m : c.conserved)
    line(fmt::format("{}: drifts by at most {:.3g} of {:.4g} (at {:.6g} s)", m.name, m.drift, m.scale,
                     m.time));
  if (c.constraint_rows > 0)
    line(fmt::format("constraints: {} rows of rank {}; least distance to dependence {:.2g} (at {:.6g} s)",
                     c.constraint_rows, c.constraint_rank, c.nearness, c.nearness_time));
  if (!c.assembly_position_coordinate.empty())
    line(fmt::format("assembly: moved the initial positions by at most {:.4g} m or rad ('{}')",
                     c.assembly_position, c.assembly_position_coordinate));
  if (!c.assembly_velocity_coordinate.empty())
    line(fmt::format("assembly: changed the initial velocities by at most {:.4g} m/s or rad/s ('{}')",
                     c.assembly_velocity, c.assembly_velocity_coordinate));
  std::size_t never_off = 0;
  for (const ConstraintResidual& r : c.residuals) {
    if (r.position == 0 && r.velocity == 0 && r.acceleration == 0) {
      ++never_off;
      continue;
    }
    line(
        fmt::format("constraint '{}': error at most {:.3g} (at {:.6g} s), of its velocity {:.3g} (at {:.6g} "
                    "s), of its acceleration {:.3g} (at {:.6g} s)",
                    r.constraint, r.position, r.position_time, r.velocity, r.velocity_time, r.acceleration,
                    r.acceleration_time));
  }
  if (never_off > 0) line(fmt::format("constraints without error: {}", never_off));
  for (const std::string& row : c.redundant) line("redundant: " + row);
  if (!c.method.empty()) line(fmt::format("integrated by {} with the {} equations", c.method, c.equations));
  line(fmt::format("steps: {} accepted, {} rejected, {} evaluations{}", c.steps_accepted, c.steps_rejected,
                   c.evaluations, smallest_step(c)));
  if (!c.step_defect_coordinate.empty())
    line(
        fmt::format("fixed steps: in '{}' they miss at most {:.2g} of a step's motion (at {:.6g} s); trusted "
                    "up to {:.2g}",
                    c.step_defect_coordinate, c.step_defect, c.step_defect_time, StepWatch::limit));
  constexpr std::size_t most_events = 100;
  for (std::size_t i = 0; i < std::min(most_events, c.events.size()); ++i)
    line(fmt::format("event at {:.9g} s: {}, {}{}", c.events[i].time, c.events[i].kind, c.events[i].name,
                     shock_of(c.events[i])));
  if (c.events.size() > most_events)
    line(fmt::format("and {} more events, all of them in the .h5 file", c.events.size() - most_events));
  for (const std::string& note : c.notes) line("note: " + note);
  return out;
}

nlohmann::json json_of(const Certificate& c) {
  nlohmann::json out;
  visit_certificate(c, [&](const std::string& name, const auto& value, Presence) {
    out[nlohmann::json::json_pointer("/" + name)] = value;
  });
  out["vouches_for"] = vouches_for(c);
  out["redundant"] = c.redundant;
  out["notes"] = c.notes;
  out["conserved"] = table_of(c.conserved);
  out["residuals"] = table_of(c.residuals);
  out["events"] = table_of(c.events);
  return out;
}

}  // namespace borelli
