#include "dynamics/formats/osim_function.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "error/printable.hpp"

namespace borelli {
namespace {

constexpr std::size_t most_values = 1'000'000;

bool is_osim_function(const XmlElement& e) {
  const std::string& n = e.name;
  return n.ends_with("Function") || n.ends_with("Spline") || n == "Constant" || n == "Sine" ||
         e.text("name") == "function";
}

double osim_number(const XmlElement& function, std::string_view child, double standard) {
  const XmlElement* e = function.child(child);
  return e ? e->content_numbers(1, 1)[0] : standard;
}

std::vector<double> osim_values(const XmlElement& function, std::string_view child) {
  return function.require_child(child).content_numbers(0, most_values);
}

// Splines of two values are lines.
TimeFunction line_through(const std::vector<double>& x, const std::vector<double>& y) {
  const double slope = (y.back() - y.front()) / (x.back() - x.front());
  return linear(y.front() - slope * x.front(), slope);
}

TimeFunction table_of(const XmlElement& function) {
  const Table table(osim_values(function, "x"), osim_values(function, "y"), SplineEnds::forsythe);
  if (const std::string bad = table.complaint(); !bad.empty()) function.refuse(bad);
  return table.times.size() == 2 ? line_through(table.times, table.values) : table;
}

// A GCVSpline of degree 3 that smooths nothing is the natural spline.
TimeFunction gcv_spline_of(const XmlElement& function) {
  if (osim_number(function, "half_order", 3) != 2 || osim_number(function, "error_variance", 0) != 0)
    function.refuse("is not an interpolating cubic spline; expected half_order 2 and error_variance 0");
  for (const char* child : {"weights", "coefficients"}) function.child(child);
  const Table table(osim_values(function, "x"), osim_values(function, "y"), SplineEnds::natural);
  if (const std::string bad = table.complaint(); !bad.empty()) function.refuse(bad);
  return table;
}

// The speed of a coordinate would jump at each bend of a piecewise linear function.
TimeFunction piecewise_of(const XmlElement& function) {
  const std::vector<double> x = osim_values(function, "x"), y = osim_values(function, "y");
  if (const std::string bad = CubicSpline::complaint(x, y, SplineEnds::natural); !bad.empty())
    function.refuse("its table: " + bad);
  const TimeFunction line = line_through(x, y);
  double largest = 0;
  for (const double value : y) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::abs(at(line, x[i]).value - y[i]) > 1e-9 * largest)
      function.refuse(fmt::format("has a corner at {:g}, where speeds would jump; use a SimmSpline", x[i]));
  return line;
}

}  // namespace

const XmlElement* osim_function_in(const XmlElement& holder) {
  const XmlElement* inside = holder.child("function");
  for (const XmlElement& c : inside ? inside->children : holder.children)
    if (inside || is_osim_function(c)) {
      c.read = true;
      return &c;
    }
  return nullptr;
}

TimeFunction read_osim_function(const XmlElement& function) {
  function.read = true;
  const std::string& kind = function.name;
  TimeFunction out;
  if (kind == "Constant") {
    out = constant(osim_number(function, "value", 0));
  } else if (kind == "LinearFunction") {
    const XmlElement* e = function.child("coefficients");
    const std::vector<double> c = e ? e->content_numbers(2, 2) : std::vector<double>{1, 0};
    out = linear(c[1], c[0]);
  } else if (kind == "PolynomialFunction") {
    std::vector<double> c = function.require_child("coefficients").content_numbers(1, 1000);
    std::reverse(c.begin(), c.end());
    out = Polynomial{c};
  } else if (kind == "Sine") {
    out = Sine{osim_number(function, "amplitude", 1), osim_number(function, "omega", 1),
               osim_number(function, "phase", 0), osim_number(function, "offset", 0)};
  } else if (kind == "SimmSpline" || kind == "NaturalCubicSpline" || kind == "natCubicSpline") {
    out = table_of(function);
  } else if (kind == "GCVSpline") {
    out = gcv_spline_of(function);
  } else if (kind == "PiecewiseLinearFunction") {
    out = piecewise_of(function);
  } else if (kind == "MultiplierFunction") {
    const XmlElement* inner = osim_function_in(function);
    if (!inner) function.refuse("has no function to multiply");
    out = scaled(read_osim_function(*inner), osim_number(function, "scale", 1));
  } else {
    function.refuse(
        "is not a supported function; expected Constant, LinearFunction, PolynomialFunction, Sine, "
        "SimmSpline, GCVSpline, PiecewiseLinearFunction or MultiplierFunction");
  }
  if (const std::string bad = complaint_of(out); !bad.empty()) function.refuse(bad);
  return out;
}

bool is_line(const TimeFunction& function) {
  const auto* polynomial = std::get_if<Polynomial>(&function);
  if (!polynomial) return false;
  const auto& c = polynomial->coefficients;
  return std::all_of(c.begin() + std::min<std::ptrdiff_t>(2, std::ssize(c)), c.end(),
                     [](double x) { return x == 0; });
}

bool is_constant(const TimeFunction& function) { return is_line(function) && at(function, 0).rate == 0; }

}  // namespace borelli
