#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <utility>

#include "dynamics/formats/scene_file.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Keys and the texts of their values, in order.
using Entries = std::vector<std::pair<std::string, std::string>>;

// ---- values ----

// The shortest text that reads back as the very same number.
std::string text_of(double value) {
  if (value == 0 && std::signbit(value)) return "-0.0";  // "-0" would be read as an integer, without its sign
  return fmt::format("{}", value);
}

std::string list_of(const auto& values) {
  std::vector<std::string> texts;
  for (const double v : values) texts.push_back(text_of(v));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string text_of(const std::vector<double>& values) { return list_of(values); }

std::string text_of(const Vector3d& v) { return list_of(v); }

std::string text_of(const Matrix3d& m) {
  return fmt::format("[{}, {}, {}]", list_of(m.row(0)), list_of(m.row(1)), list_of(m.row(2)));
}

std::string text_of(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += std::string("\\") + c;
    else if (c == '\n')
      out += "\\n";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

// Text of several lines as a multi-line string.
std::string prose_of(const std::string& text) {
  if (text.find('\n') == std::string::npos) return text_of(text);
  std::string lines = text_of(text), out = "\"\"\"\n";
  lines = lines.substr(1, lines.size() - 2);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] == '\\' && lines[i + 1] == 'n') {
      out += '\n';
      ++i;
    } else if (lines[i] == '\\') {
      out += lines[i];
      out += lines[++i];
    } else {
      out += lines[i];
    }
  }
  return out + "\"\"\"";
}

std::string axis_of(const Vector3d& axis) {
  constexpr std::string_view letters = "xyz";
  for (int i = 0; i < 3; ++i) {
    if (axis == Vector3d::Unit(i)) return fmt::format("\"{}\"", letters[i]);
    if (axis == -Vector3d::Unit(i)) return fmt::format("\"-{}\"", letters[i]);
  }
  return text_of(axis);
}

std::string in_line(const Entries& entries) {
  std::vector<std::string> texts;
  for (const auto& [key, text] : entries) texts.push_back(key + " = " + text);
  return fmt::format("{{{}}}", fmt::join(texts, ", "));
}

void add_turn(Entries& entries, const Matrix3d& R) {
  if (R != Matrix3d::Identity()) entries.emplace_back("matrix", text_of(R));
}

std::string ranges_of(const std::vector<Range>& ranges) {
  std::vector<std::string> texts;
  for (const Range& r : ranges) texts.push_back(text_of(std::vector{r.lower, r.upper}));
  return texts.size() == 1 ? texts[0] : fmt::format("[{}]", fmt::join(texts, ", "));
}

// ---- shapes ----

Entries form_of(const Box& b) { return {{"kind", "\"box\""}, {"size", text_of(b.size)}}; }
Entries form_of(const Sphere& s) { return {{"kind", "\"sphere\""}, {"radius", text_of(s.radius)}}; }
Entries form_of(const Ellipsoid& e) { return {{"kind", "\"ellipsoid\""}, {"radii", text_of(e.radii)}}; }
Entries form_of(const Cylinder& c) {
  return {{"kind", "\"cylinder\""}, {"radius", text_of(c.radius)}, {"length", text_of(c.length)}};
}
Entries form_of(const Cone& c) {
  return {{"kind", "\"cone\""}, {"radius", text_of(c.radius)}, {"length", text_of(c.length)}};
}
Entries form_of(const Capsule& c) {
  return {{"kind", "\"capsule\""}, {"radius", text_of(c.radius)}, {"length", text_of(c.length)}};
}
Entries form_of(const ClosedMesh& m) {
  std::vector<std::string> vertices, triangles;
  for (const Vector3d& p : m.vertices) vertices.push_back(text_of(p));
  for (const auto& t : m.triangles) triangles.push_back(fmt::format("[{}]", fmt::join(t, ", ")));
  return {{"kind", "\"mesh\""},
          {"vertices", fmt::format("[{}]", fmt::join(vertices, ", "))},
          {"triangles", fmt::format("[{}]", fmt::join(triangles, ", "))}};
}

Entries placed_form(const Shape& shape) {
  Entries out = std::visit([](const auto& form) { return form_of(form); }, shape.form);
  if (shape.position != Vector3d::Zero()) out.emplace_back("position", text_of(shape.position));
  const Eigen::Quaterniond& q = shape.orientation;
  if (q.coeffs() != Eigen::Quaterniond::Identity().coeffs())
    out.emplace_back("quaternion", text_of(std::vector{q.w(), q.x(), q.y(), q.z()}));
  return out;
}

// ---- fields of efforts, constraints, functions of time ----

struct FieldWriter {
  Entries& entries;

  void add(std::string_view key, std::string text) { entries.emplace_back(key, std::move(text)); }

  void operator()(std::string_view key, const double& field) { add(key, text_of(field)); }
  void operator()(std::string_view key, const Vector3d& field) {
    add(key, is_direction(key) ? axis_of(field) : text_of(field));
  }
  void operator()(std::string_view key, const std::optional<double>& field) {
    if (field) add(key, text_of(*field));
  }
  void operator()(std::string_view key, const std::vector<double>& field) { add(key, text_of(field)); }
  void operator()(std::string_view key, const SolidPoint& field) { add(key, point(field)); }
  void operator()(std::string_view key, const SolidName& field) { add(key, text_of(field.solid)); }
  void operator()(std::string_view key, const CoordinateName& field) { add(key, text_of(field.coordinate)); }
  void operator()(std::string_view key, const std::vector<CoordinateName>& field) {
    std::vector<std::string> texts;
    for (const CoordinateName& c : field) texts.push_back(text_of(c.coordinate));
    add(key, fmt::format("[{}]", fmt::join(texts, ", ")));
  }
  void operator()(std::string_view key, const AnyCoordinate& field) { add(key, text_of(field.coordinate)); }
  void operator()(std::string_view key, const std::vector<Range>& field) {
    if (!field.empty()) add(key, ranges_of(field));
  }
  // several functions: each as a list or a table, to distinguish them from the coefficients of one polynomial
  void operator()(std::string_view key, const std::vector<TimeFunction>& field) {
    std::vector<std::string> texts;
    for (const TimeFunction& f : field) {
      const auto* p = std::get_if<Polynomial>(&f);
      texts.push_back(p && field.size() > 1 ? text_of(p->coefficients) : time_function(f));
    }
    if (!texts.empty()) add(key, texts.size() == 1 ? texts[0] : fmt::format("[{}]", fmt::join(texts, ", ")));
  }
  void operator()(std::string_view key, const std::optional<SolidPoint>& field) {
    if (field) add(key, point(*field));
  }
  void operator()(std::string_view key, const std::optional<SolidName>& field) {
    if (field) add(key, text_of(field->solid));
  }
  void operator()(std::string_view key, const Axes& field) {
    add(key, field == Axes::world ? "\"world\"" : "\"solid\"");
  }
  void operator()(std::string_view key, const SplineEnds& field) {
    add(key, text_of(std::string(spline_ends_names[static_cast<int>(field)])));
  }
  void operator()(std::string_view key, const std::vector<Vector3d>& field) {
    std::vector<std::string> texts;
    for (const Vector3d& p : field) texts.push_back(text_of(p));
    add(key, fmt::format("[{}]", fmt::join(texts, ", ")));
  }
  void operator()(std::string_view key, const bool& field) { add(key, field ? "true" : "false"); }
  void operator()(std::string_view key, const TimeFunction& field) { add(key, time_function(field)); }
  void operator()(std::string_view key, const Pose& field) {
    Entries pose{{"position", text_of(field.p)}};
    add_turn(pose, field.R);
    add(key, in_line(pose));
  }
  void operator()(std::string_view key, const Shape& field) { add(key, in_line(placed_form(field))); }

  static std::string point(const SolidPoint& p) {
    return in_line({{"solid", text_of(p.solid)}, {"point", text_of(p.point)}});
  }

  static std::string time_function(const TimeFunction& function) {
    if (const auto* p = std::get_if<Polynomial>(&function))
      return p->coefficients.size() == 1 ? text_of(p->coefficients[0]) : text_of(p->coefficients);
    Entries entries;
    std::visit(
        [&]<class T>(const T& f) {
          entries.emplace_back("kind", text_of(std::string(T::kind)));
          T::fields(f, FieldWriter{entries});
        },
        function);
    return in_line(entries);
  }
};

// The fields that differ from a default-constructed struct; the kind first. Required fields always differ or
// are sites.
template <class T>
Entries entries_of(const T& value) {
  Entries given, fresh, out{{"kind", text_of(std::string(T::kind))}};
  const T empty;
  T::fields(value, FieldWriter{given});
  T::fields(empty, FieldWriter{fresh});
  const std::string world_point = FieldWriter::point({}), world = text_of(std::string(world_name));
  for (auto& entry : given) {
    const bool as_ever = std::find(fresh.begin(), fresh.end(), entry) != fresh.end();
    const bool is_site = entry.second == world_point || entry.second == world;
    if (!as_ever || (is_site && entry.first != "axes") || entry.first == T::kind)
      out.push_back(std::move(entry));
  }
  return out;
}

// ---- solids ----

// A switch's axis under its kind's own key, the others under their names.
struct SwitchWriter {
  Entries& entries;
  std::string_view kind;

  void operator()(std::string_view key, const Vector3d& field) const {
    if (is_direction(key))
      entries.emplace_back(kind, axis_of(field));
    else
      entries.emplace_back(key, text_of(field));
  }
  void operator()(std::string_view key, const double& number) const {
    entries.emplace_back(key, text_of(number));
  }
};

std::string parts_of(const Guided& guided) {
  std::vector<std::string> texts;
  for (const GuidedPart& part : guided.parts)
    texts.push_back(
        in_line({{std::string(guided_part_names[static_cast<int>(part.kind)]), axis_of(part.axis)},
                 {"by", FieldWriter::time_function(part.by)}}));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string switch_of(const Switch& s) {
  Entries out;
  std::visit(
      [&]<class T>(const T& kind) {
        if constexpr (std::is_same_v<T, Fixed>) {
          out.emplace_back(T::kind, text_of(kind.X_AB.p));
          add_turn(out, kind.X_AB.R);
        } else if constexpr (std::is_same_v<T, Guided>) {
          out.emplace_back(T::kind, parts_of(kind));
        } else {
          if constexpr (!requires { kind.axis; }) out.emplace_back(T::kind, "true");
          T::fields(kind, SwitchWriter{out, T::kind});
        }
      },
      s.kind);
  const auto values = [](const std::vector<double>& v) { return v.size() == 1 ? text_of(v[0]) : text_of(v); };
  if (!s.coordinate.empty()) out.emplace_back("name", text_of(s.coordinate));
  if (!s.q.empty()) out.emplace_back("value", values(s.q));
  if (!s.v.empty()) out.emplace_back("velocity", values(s.v));
  if (!s.ranges.empty()) out.emplace_back("range", ranges_of(s.ranges));
  if (s.armature != 0) out.emplace_back("armature", text_of(s.armature));
  if (std::holds_alternative<Locked>(s.motion)) out.emplace_back("locked", "true");
  if (const auto* coupled = std::get_if<Coupled>(&s.motion))
    out.emplace_back("coupled", in_line({{"to", text_of(coupled->to)},
                                         {"function", FieldWriter::time_function(coupled->function)}}));
  if (const auto* driven = std::get_if<Driven>(&s.motion)) {
    std::vector<std::string> functions;
    for (const TimeFunction& f : driven->functions) functions.push_back(FieldWriter::time_function(f));
    out.emplace_back("driven",
                     functions.size() == 1 ? functions[0] : fmt::format("[{}]", fmt::join(functions, ", ")));
  }
  return in_line(out);
}

std::string tensor_of(const Matrix3d& t) {
  if (t != t.transpose()) return text_of(t);
  std::vector<double> entries{t(0, 0), t(1, 1), t(2, 2)};
  const std::vector<double> products{t(0, 1), t(0, 2), t(1, 2)};
  if (products != std::vector<double>{0, 0, 0})
    entries.insert(entries.end(), products.begin(), products.end());
  return text_of(entries);
}

Entries inertial_of(const Inertial& i) {
  return {{"mass", text_of(i.mass)}, {"centre", text_of(i.centre)}, {"tensor", tensor_of(i.tensor)}};
}

std::string shape_of(const ShapeElement& element) {
  Entries out = placed_form(element.shape);
  if (element.density) out.emplace_back("density", text_of(*element.density));
  if (element.mass) out.emplace_back("mass", text_of(*element.mass));
  return in_line(out);
}

// One entry on one line; several entries one per line.
std::string several(const std::vector<std::string>& entries) {
  if (entries.size() == 1) return fmt::format("[{}]", entries[0]);
  return fmt::format("[\n  {},\n]", fmt::join(entries, ",\n  "));
}

std::string lines_of(const std::string& header, const Entries& entries) {
  std::string out = "\n" + header + "\n";
  for (const auto& [key, text] : entries) out += key + " = " + text + "\n";
  return out;
}

std::string solid_of(const Solid& solid) {
  Entries out{{"name", text_of(solid.name)}, {"parent", text_of(solid.parent)}};
  std::vector<std::string> entries;
  for (const Switch& s : solid.switches) entries.push_back(switch_of(s));
  if (!entries.empty()) out.emplace_back("joint", several(entries));
  if (solid.inertials.size() == 1) {
    for (auto& entry : inertial_of(solid.inertials[0])) out.push_back(std::move(entry));
  } else if (!solid.inertials.empty()) {
    entries.clear();
    for (const Inertial& i : solid.inertials) entries.push_back(in_line(inertial_of(i)));
    out.emplace_back("inertial", several(entries));
  }
  entries.clear();
  for (const ShapeElement& s : solid.shapes) entries.push_back(shape_of(s));
  if (!entries.empty()) out.emplace_back("shape", several(entries));
  return lines_of("[[solid]]", out);
}

// Collects every setting as text.
struct SettingTexts {
  Entries out = {};
  void operator()(const char* key, bool yes) { out.emplace_back(key, yes ? "true" : "false"); }
  void operator()(const char* key, double number) { out.emplace_back(key, text_of(number)); }
  void operator()(const char* key, const std::string& text) { out.emplace_back(key, text_of(text)); }
  template <class Choice>
  void operator()(const char* key, Choice choice, const std::array<std::string_view, 2>& words) {
    out.emplace_back(key, text_of(std::string(words[std::size_t(choice)])));
  }
};

Entries simulation_of(const SimulationSettings& s) {
  SettingTexts given, fresh;
  SimulationSettings::fields(s, given);
  const SimulationSettings defaults;
  SimulationSettings::fields(defaults, fresh);
  Entries out;
  for (std::size_t i = 0; i < given.out.size(); ++i) {
    const auto& [key, text] = given.out[i];
    const bool always = key == "end_time" || key == "step" || key == "output_interval";
    // An accuracy chooses method and tolerance.
    const bool chosen = key == "method" || key == "tolerance";
    if (chosen ? !(s.accuracy > 0) : always || text != fresh.out[i].second) out.push_back(given.out[i]);
  }
  return out;
}

// The text of an effort or a constraint; fails if its kind is user C++.
template <class Action>
Result<std::string> action_of(const std::string& what, const Action& action) {
  return std::visit(
      [&]<class Kind>(const Kind& kind) -> Result<std::string> {
        if constexpr (IsCode<Kind>) {
          return bad_use(
              fmt::format("{} '{}'", what, action.name),
              fmt::format("is written in C++, which a scene file cannot contain; use another kind of {}",
                          what));
        } else {
          Entries out{{"name", text_of(action.name)}};
          for (auto& entry : entries_of(kind)) out.push_back(std::move(entry));
          return lines_of(fmt::format("[[{}]]", what), out);
        }
      },
      action.kind);
}

}  // namespace

Result<std::string> write_scene(const Scene& scene) {
  std::string out;
  if (!scene.name.empty()) out += "name = " + text_of(scene.name) + "\n";
  if (!scene.description.empty()) out += "description = " + prose_of(scene.description) + "\n";
  out += "gravity = " + text_of(scene.gravity) + "\n";
  out += lines_of("[simulation]", simulation_of(scene.simulation));
  for (const Solid& solid : scene.solids) out += solid_of(solid);
  Result<void> fine;
  const auto add_all = [&](const std::string& what, const auto& actions) {
    for (const auto& action : actions) {
      const auto text = action_of(what, action);
      if (text)
        out += *text;
      else if (fine)
        fine = tl::unexpected(text.error());
    }
  };
  add_all("effort", scene.efforts);
  add_all("constraint", scene.constraints);
  if (!fine) return tl::unexpected(fine.error());
  for (const Marker& marker : scene.markers)
    out += lines_of("[[marker]]", {{"name", text_of(marker.name)},
                                   {"solid", text_of(marker.at.solid)},
                                   {"point", text_of(marker.at.point)}});
  return out;
}

}  // namespace borelli
