#include "dynamics/formats/osim_frames.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "dynamics/scene/site.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr int deepest_frame = 100;          // of frames on frames
constexpr std::size_t longest_path = 1000;  // longer paths, which no model has, would eat memory

bool is_osim_frame(const XmlElement& e) {
  return e.name == "Body" || e.name == "Ground" || e.name == "PhysicalOffsetFrame";
}

// Lists whose names are no part of a path.
bool is_list(const XmlElement& e) {
  return e.name == "objects" || e.name == "frames" || e.name == "components" || e.name == "coordinates" ||
         e.name == "Joint";
}

std::string segment_of(const XmlElement& e) {
  std::string out = e.text("name");
  if (out.empty()) {
    out = e.name;
    std::transform(out.begin(), out.end(), out.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  }
  return out;
}

// "/jointset/hip" and "../knee/offset" give "/jointset/knee/offset".
std::string joined_paths(const std::string& from, const std::string& path) {
  std::vector<std::string> parts;
  const auto add = [&](const std::string& text) {
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find('/', at), text.size());
      const std::string part = text.substr(at, end - at);
      at = end + 1;
      if (part.empty() || part == ".") continue;
      if (part != "..")
        parts.push_back(part);
      else if (!parts.empty())
        parts.pop_back();
    }
  };
  if (!path.starts_with('/')) add(from);
  add(path);
  std::string out;
  for (const std::string& part : parts) out += "/" + part;
  return out;
}

}  // namespace

Eigen::Matrix3d osim_rotation(const Vector3d& angles) {
  return rotation_about(Vector3d::UnitX(), angles[0]) * rotation_about(Vector3d::UnitY(), angles[1]) *
         rotation_about(Vector3d::UnitZ(), angles[2]);
}

Vector3d osim_vector(const XmlElement& element, std::string_view child, const Vector3d& standard) {
  const XmlElement* e = element.child(child);
  if (!e) return standard;
  const std::vector<double> x = e->content_numbers(3, 3);
  return {x[0], x[1], x[2]};
}

std::string osim_text(const XmlElement& element, std::string_view child) {
  const XmlElement* e = element.child(child);
  return e ? e->content : "";
}

bool osim_flag(const XmlElement& element, std::string_view child, bool standard) {
  const XmlElement* e = element.child(child);
  if (!e || e->content.empty()) return standard;
  if (e->content == "true" || e->content == "True" || e->content == "1") return true;
  if (e->content == "false" || e->content == "False" || e->content == "0") return false;
  e->refuse(fmt::format("is '{}', expected true or false", printable(e->content)));
}

OsimFrames::OsimFrames(const XmlElement& model) { collect(model, ""); }

void OsimFrames::collect(const XmlElement& element, const std::string& path) {
  if (path.size() > longest_path) return;
  paths_[&element] = path;
  for (const XmlElement& c : element.children) {
    const std::string own = is_list(c) ? path : path + "/" + segment_of(c);
    if (is_osim_frame(c)) {
      by_path_.emplace(own, &c);
      by_name_.emplace(c.name == "Ground" ? "ground" : c.text("name"), &c);
    }
    collect(c, own);
  }
}

OsimFrame OsimFrames::find(const XmlElement& element, const std::string& name) const {
  return look_up(element, name, 0);
}

OsimFrame OsimFrames::named_by(const XmlElement& element,
                               const std::vector<std::string_view>& children) const {
  for (const std::string_view child : children)
    if (const XmlElement* e = element.child(child)) return look_up(element, e->content, 0);
  element.refuse(fmt::format("has no <{}>", children.front()));
}

OsimFrame OsimFrames::look_up(const XmlElement& element, const std::string& name, int depth) const {
  const std::string last = name.substr(name.find_last_of('/') + 1);
  if (last == "ground") return {world_name, {}};
  const auto own = paths_.find(&element);
  if (const auto at = by_path_.find(joined_paths(own == paths_.end() ? "" : own->second, name));
      at != by_path_.end())
    return place(*at->second, depth);
  const auto [first, end] = by_name_.equal_range(last);
  const XmlElement* found = nullptr;
  for (auto at = first; at != end; ++at)  // a body has its name for itself
    if (!found || at->second->name == "Body") found = at->second;
  if (!found || (std::distance(first, end) > 1 && found->name != "Body"))
    element.refuse(fmt::format("no {}frame is named '{}'", found ? "single " : "", printable(name)));
  return place(*found, depth);
}

OsimFrame OsimFrames::place(const XmlElement& frame, int depth) const {
  if (frame.name == "Ground") return {world_name, {}};
  if (frame.name == "Body") return {frame.text("name"), {}};
  if (depth > deepest_frame) frame.refuse("its chain of parents is a loop, or longer than 100");
  frame.read = true;
  const XmlElement& parent = frame.require_child("socket_parent");
  OsimFrame out = look_up(frame, parent.content, depth + 1);
  out.X = out.X * Pose{osim_rotation(osim_vector(frame, "orientation")), osim_vector(frame, "translation")};
  return out;
}

}  // namespace borelli
