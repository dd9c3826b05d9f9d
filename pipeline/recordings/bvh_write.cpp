#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "error/printable.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/recordings/bvh_file.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

Result<void> check_bvh(const BvhMotion& motion, const std::string& name) {
  const auto refuse = [&](const std::string& what) { return failure(name, "cannot be written: " + what); };
  if (motion.joints.empty()) return refuse("it has no joint");
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < motion.joints.size(); ++i) {
    const BvhJoint& joint = motion.joints[i];
    const std::string shown = printable(joint.name);
    if (joint.parent >= static_cast<int>(i) || joint.parent < -1)
      return refuse(fmt::format("the joint '{}' does not come after its parent", shown));
    if (joint.end_site && (joint.parent < 0 || !joint.channels.empty()))
      return refuse(fmt::format("the End Site '{}' has channels or no parent", shown));
    if (joint.parent >= 0 && motion.joints[static_cast<std::size_t>(joint.parent)].end_site)
      return refuse(fmt::format("the joint '{}' hangs on an End Site", shown));
    if (!joint.offset.allFinite()) return refuse(fmt::format("the offset of '{}' is not finite", shown));
    if (joint.end_site) continue;
    if (trimmed(joint.name) != joint.name || joint.name.empty() ||
        joint.name.find_first_of("{}\r\n") != std::string::npos || !names.insert(joint.name).second)
      return refuse(
          fmt::format("the joint name '{}' is empty, doubled, or holds braces, line ends or blanks "
                      "around it",
                      shown));
  }
  if (motion.values.cols() != motion.first_channels().back())
    return refuse(fmt::format("it has {} values in a frame for {} channels", motion.values.cols(),
                              motion.first_channels().back()));
  if (!motion.values.allFinite()) return refuse("it holds a value that is not finite");
  if (motion.values.rows() > 0 && !(motion.frame_time > 0 && std::isfinite(motion.frame_time)))
    return refuse(fmt::format("its frame time is {:g} s", motion.frame_time));
  return {};
}

// A chain of joints would otherwise take more blanks than words.
std::string indent_of(std::size_t depth) { return std::string(std::min<std::size_t>(depth, 40), '\t'); }

// The joints below each; one more list, the first, for the roots.
std::vector<std::vector<int>> children_of(const BvhMotion& motion) {
  std::vector<std::vector<int>> children(motion.joints.size() + 1);
  for (std::size_t i = 0; i < motion.joints.size(); ++i)
    children[static_cast<std::size_t>(motion.joints[i].parent + 1)].push_back(static_cast<int>(i));
  return children;
}

std::string head_of_joint(const BvhJoint& joint, const std::string& indent) {
  std::string out = indent + (joint.end_site     ? "End Site"
                              : joint.parent < 0 ? "ROOT " + joint.name
                                                 : "JOINT " + joint.name);
  out += fmt::format("\n{0}{{\n{0}\tOFFSET {1} {2} {3}\n", indent, exact(joint.offset[0]),
                     exact(joint.offset[1]), exact(joint.offset[2]));
  if (joint.end_site) return out;
  out += fmt::format("{}\tCHANNELS {}", indent, joint.channels.size());
  for (const BvhChannel& channel : joint.channels)
    out += fmt::format(" {}{}", "XYZ"[channel.axis], channel.rotation ? "rotation" : "position");
  return out + "\n";
}

// Writes the hierarchy depth first; `order` is the order of the joints in the text.
void put_hierarchy(const BvhMotion& motion, std::string& out, std::vector<int>& order) {
  const auto children = children_of(motion);
  struct Open {
    int joint;
    std::size_t next;
  };
  std::vector<Open> open{{-1, 0}};
  while (!open.empty()) {
    const auto& below = children[static_cast<std::size_t>(open.back().joint + 1)];
    if (open.back().next < below.size()) {
      const int joint = below[open.back().next++];
      out += head_of_joint(motion.joints[static_cast<std::size_t>(joint)], indent_of(open.size() - 1));
      order.push_back(joint);
      open.push_back({joint, 0});
    } else {
      open.pop_back();
      if (!open.empty()) out += indent_of(open.size() - 1) + "}\n";
    }
  }
}

}  // namespace

Result<std::string> bvh_text(const BvhMotion& motion, const std::string& name) {
  if (auto fine = check_bvh(motion, name); !fine) return tl::unexpected(fine.error());
  std::string out = "HIERARCHY\n";
  std::vector<int> order;
  put_hierarchy(motion, out, order);
  if (!(motion.frame_time > 0)) return out;
  out += fmt::format("MOTION\nFrames: {}\nFrame Time: {}\n", motion.values.rows(), exact(motion.frame_time));
  const auto first = motion.first_channels();
  for (Eigen::Index frame = 0; frame < motion.values.rows(); ++frame) {
    std::string line;
    for (const int joint : order)
      for (Eigen::Index i = first[static_cast<std::size_t>(joint)];
           i < first[static_cast<std::size_t>(joint) + 1]; ++i)
        line += (line.empty() ? "" : " ") + exact(motion.values(frame, i));
    out += line + "\n";
  }
  return out;
}

Result<void> write_bvh(const BvhMotion& motion, const std::filesystem::path& path) {
  const auto text = bvh_text(motion, path.string());
  if (!text) return tl::unexpected(text.error());
  return write_bytes(path, *text);
}

}  // namespace borelli
