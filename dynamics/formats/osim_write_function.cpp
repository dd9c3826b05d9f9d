#include "dynamics/formats/osim_write_function.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace borelli {
namespace {

// GCVSpline needs a value more than its degree.
constexpr std::size_t least_gcv_values = 4;

void write_osim_polynomial(XmlNode& holder, std::vector<double> c, const std::string& name) {
  while (!c.empty() && c.back() == 0) c.pop_back();
  if (c.size() <= 1) {
    holder.add("Constant").set("name", name).add("value", exact_text(c.empty() ? 0 : c[0]));
    return;
  }
  std::reverse(c.begin(), c.end());  // highest power first
  holder.add(c.size() == 2 ? "LinearFunction" : "PolynomialFunction")
      .set("name", name)
      .add("coefficients", exact_text(c));
}

void write_osim_table(XmlNode& holder, const Table& table, const std::string& name) {
  if (table.times.size() == 2) {
    const double slope = (table.values[1] - table.values[0]) / (table.times[1] - table.times[0]);
    write_osim_polynomial(holder, {table.values[0] - slope * table.times[0], slope}, name);
    return;
  }
  const bool natural = table.ends == SplineEnds::natural;
  XmlNode& spline = holder.add(natural ? "GCVSpline" : "SimmSpline").set("name", name);
  if (natural) {
    spline.add("half_order", "2");
    spline.add("error_variance", "0");
  }
  spline.add("x", exact_text(table.times));
  spline.add("y", exact_text(table.values));
  if (natural) spline.add("weights", exact_text(std::vector<double>(table.times.size(), 1.)));
}

}  // namespace

std::string osim_function_complaint(const TimeFunction& function) {
  const auto* table = std::get_if<Table>(&function);
  if (!table || table->ends == SplineEnds::forsythe) return "";
  if (table->ends != SplineEnds::natural)
    return fmt::format("follow a {} spline, which OpenSim does not have",
                       spline_ends_names[std::size_t(table->ends)]);
  const std::size_t count = table->times.size();
  if (count == 2 || count >= least_gcv_values) return "";
  return "follow a natural spline of three values, which OpenSim does not have";
}

void write_osim_function(XmlNode& holder, const TimeFunction& function, const std::string& name) {
  if (const auto* polynomial = std::get_if<Polynomial>(&function)) {
    write_osim_polynomial(holder, polynomial->coefficients, name);
  } else if (const auto* table = std::get_if<Table>(&function)) {
    write_osim_table(holder, *table, name);
  } else {
    const auto& sine = std::get<Sine>(function);
    XmlNode& node = holder.add("Sine").set("name", name);
    node.add("amplitude", exact_text(sine.amplitude));
    node.add("omega", exact_text(sine.angular_frequency));
    node.add("phase", exact_text(sine.phase));
    node.add("offset", exact_text(sine.offset));
  }
}

}  // namespace borelli
