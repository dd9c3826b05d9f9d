#include "dynamics/formats/mjcf_edit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace borelli {

std::string mjcf_numbers(const std::vector<double>& numbers) {
  std::string out;
  for (const double x : numbers) out += fmt::format("{}{:.17g}", out.empty() ? "" : " ", x);
  return out;
}

void set_attribute(XmlElement& element, std::string_view key, std::string value) {
  for (XmlAttribute& a : element.attributes)
    if (a.name == key) {
      a.value = std::move(value);
      return;
    }
  element.attributes.push_back(
      {.name = std::string(key), .value = std::move(value), .where = element.where()});
}

void remove_attribute(XmlElement& element, std::string_view key) {
  std::erase_if(element.attributes, [&](const XmlAttribute& a) { return a.name == key; });
}

void set_pose(XmlElement& element, const Pose& X) {
  for (const char* key : {"axisangle", "euler", "xyaxes", "zaxis"}) remove_attribute(element, key);
  const Quaternion q = quaternion(X.R);
  set_attribute(element, "pos", mjcf_numbers({X.p.x(), X.p.y(), X.p.z()}));
  set_attribute(element, "quat", mjcf_numbers({q[0], q[1], q[2], q[3]}));
}

XmlElement made_from(const XmlElement& origin, std::string name) {
  XmlElement out;
  out.name = std::move(name);
  out.file = origin.file;
  out.line = origin.line;
  out.part = origin.part;
  return out;
}

int whole_number(const XmlElement& element, std::string_view key, int standard) {
  const double x = element.number(key, standard);
  if (x != std::floor(x) || !(std::abs(x) < 2147483648.0))
    element.refuse(key, fmt::format("{} is {:g}, expected a whole number of 32 bits", key, x));
  return static_cast<int>(x);
}

std::size_t count_elements(const XmlElement& element) {
  std::size_t out = 1;
  for (const XmlElement& c : element.children) out += count_elements(c);
  return out;
}

}  // namespace borelli
