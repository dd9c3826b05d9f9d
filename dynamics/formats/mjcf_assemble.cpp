#include "dynamics/formats/mjcf_assemble.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <list>
#include <map>
#include <set>

#include "dynamics/formats/mjcf_cable.hpp"
#include "dynamics/formats/mjcf_defaults.hpp"
#include "dynamics/formats/mjcf_edit.hpp"
#include "dynamics/formats/mjcf_include.hpp"
#include "dynamics/formats/mjcf_names.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using TreeName = std::pair<std::string, std::string>;  // kind ("body", "joint", "geom" or "site") and name
using TreeNames = std::set<TreeName>;
using Elements = std::vector<XmlElement>;

constexpr int most_attached = 50;  // depth of models attached to models

std::string kind_named_by(const std::string& element) { return element == "freejoint" ? "joint" : element; }

void add_names(const XmlElement& e, TreeNames& out) {
  for (const XmlAttribute& a : e.attributes)
    if (a.name == "name") out.emplace(kind_named_by(e.name), a.value);
  for (const XmlElement& c : e.children) add_names(c, out);
}

TreeNames names_of(const Elements& elements) {
  TreeNames out;
  for (const XmlElement& e : elements) add_names(e, out);
  return out;
}

struct Renaming {
  std::string prefix, suffix;
  std::string operator()(const std::string& name) const {
    return name.empty() ? name : prefix + name + suffix;
  }
};

void rename(XmlElement& e, const Renaming& to, bool meshes) {
  for (XmlAttribute& a : e.attributes)
    if (a.name == "name" || (meshes && a.name == "mesh" && e.name == "geom")) a.value = to(a.value);
  for (XmlElement& c : e.children) rename(c, to, meshes);
}

// ---- references from <equality> and <contact> ----

bool is_referring(const XmlElement& section) {
  return section.name == "equality" || section.name == "contact";
}

// The kind and name that body1, geom2, ... refer to.
TreeName named_by(const XmlAttribute& a) { return {a.name.substr(0, a.name.size() - 1), a.value}; }
bool is_reference(const XmlAttribute& a) {
  for (const char* kind : {"body", "joint", "geom", "site"})
    if (a.name == std::string(kind) + "1" || a.name == std::string(kind) + "2") return a.value != "world";
  return false;
}

enum class Share { none, some, all };

Share names_in(const XmlElement& e, const TreeNames& names) {
  int in = 0, out = 0;
  for (const XmlAttribute& a : e.attributes)
    if (is_reference(a)) ++(names.contains(named_by(a)) ? in : out);
  return in == 0 ? Share::none : out == 0 ? Share::all : Share::some;
}

XmlElement renamed_reference(XmlElement e, const Renaming& to) {
  for (XmlAttribute& a : e.attributes)
    if (is_reference(a) || a.name == "name") a.value = to(a.value);
  return e;
}

// ---- places ----

// Replaces fromto by pos, quat and size, so that a frame can move the geom.
void replace_fromto(XmlElement& geom) {
  const auto ends = geom.numbers("fromto", 6, 6);
  if (ends.empty()) return;
  const Vector3d from(ends[0], ends[1], ends[2]), to(ends[3], ends[4], ends[5]);
  const double half = (to - from).norm() / 2;
  auto size = geom.numbers("size", 1, 3);
  if (half < 1e-14 || size.empty() || geom.has("pos")) return;  // refused by the reader of geoms
  const std::string type = geom.text("type", "sphere");
  const bool round = type == "capsule" || type == "cylinder";
  if (!round && type != "ellipsoid" && type != "box") return;
  size = round ? std::vector{size[0], half} : std::vector{size[0], size[0], half};
  set_attribute(geom, "size", mjcf_numbers(size));
  remove_attribute(geom, "fromto");
  set_pose(geom, {turn_from_z(from - to), (from + to) / 2});
}

class Assembler {
 public:
  // Expands includes and defaults of a model, but not yet copies and attachments.
  XmlElement prepare(XmlElement root) {
    put_in_includes(root);
    check_mjcf_names(root);
    apply_mjcf_defaults(root);
    compilers_.all.push_back(MjcfCompiler::read(root));
    set_part(root, static_cast<int>(compilers_.all.size()) - 1);
    return root;
  }

  void put_together(XmlElement& root, int depth) {
    Model model{root, {}, {}, depth};
    const auto attaches_itself = [](const auto& self, const XmlElement& e) -> bool {
      return (e.name == "attach" && !e.has("model")) ||
             std::any_of(e.children.begin(), e.children.end(),
                         [&](const XmlElement& c) { return self(self, c); });
    };
    if (attaches_itself(attaches_itself, root)) model.before = root;
    for (XmlElement& section : root.children)
      if (section.name == "worldbody") expand(section, model);
    std::move(model.added.begin(), model.added.end(), std::back_inserter(root.children));
  }

  MjcfCompilers take_compilers() { return std::move(compilers_); }

 private:
  struct Model {
    XmlElement& root;
    XmlElement before;            // the root before expansion, for models that attach parts of themselves
    std::list<XmlElement> added;  // sections from attached models
    int depth;                    // depth of attachment
  };

  static void set_part(XmlElement& e, int part) {
    e.part = part;
    for (XmlElement& c : e.children) set_part(c, part);
  }

  void expand(XmlElement& parent, Model& model) {
    Elements out;
    for (XmlElement& c : parent.children) {
      if (c.name == "frame") {
        for (XmlElement& inner : out_of_frame(c, model)) out.push_back(std::move(inner));
      } else if (c.name == "replicate") {
        for (XmlElement& copy : replicas(c, model)) out.push_back(std::move(copy));
      } else if (c.name == "attach") {
        for (XmlElement& part : attached(c, model)) out.push_back(std::move(part));
      } else if (c.name == "composite") {
        MjcfCable cable = make_mjcf_cable(c);
        grow(c, 5 * cable.excludes.size());
        out.push_back(std::move(cable.body));
        XmlElement& section = model.added.emplace_back(made_from(c, "contact"));
        section.children = std::move(cable.excludes);
      } else {
        if (c.name == "body") expand(c, model);
        out.push_back(std::move(c));
      }
    }
    parent.children = std::move(out);
  }

  Elements out_of_frame(XmlElement& frame, Model& model) {
    expand(frame, model);
    const Pose X = compilers_.of(frame).pose_of(frame);
    for (XmlElement& inner : frame.children) move(inner, X);
    return std::move(frame.children);
  }

  // Transforms a child of a frame into the frame's parent.
  void move(XmlElement& e, const Pose& X) const {
    if (e.name == "joint") {
      const std::string type = e.text("type", "hinge");
      if (type == "free") return;
      const Vector3d p = X * e.vector("pos", Vector3d::Zero());
      set_attribute(e, "pos", mjcf_numbers({p.x(), p.y(), p.z()}));
      if (type == "ball") return;
      const Vector3d axis = X.R * e.vector("axis", Vector3d::UnitZ());
      set_attribute(e, "axis", mjcf_numbers({axis.x(), axis.y(), axis.z()}));
      return;
    }
    if (e.name == "geom") replace_fromto(e);
    if (e.name == "body" || e.name == "geom" || e.name == "site")
      set_pose(e, X * compilers_.of(e).pose_of(e));
  }

  // The copies of a <replicate>. Their names end in the number of the copy, padded to the digits of `count`.
  Elements replicas(XmlElement& e, Model& model) {
    expand(e, model);
    const double count = e.number("count", 0);
    if (!(count >= 1) || count > 1e6 || count != std::floor(count))
      e.refuse("count", fmt::format("expected a count from 1 to 1000000, found {:g}", count));
    const MjcfCompiler& compiler = compilers_.of(e);
    const Vector3d offset = e.vector("offset", Vector3d::Zero()), euler = e.vector("euler", Vector3d::Zero());
    const std::string separator = e.text("sep");
    const TreeNames names = names_of(e.children);
    std::vector<std::pair<XmlElement*, XmlElement>> references = take_references(e, names, model);
    const std::size_t size = count_elements(e) + references.size(),
                      digits = fmt::format("{:g}", count).size();
    grow(e, size * static_cast<std::size_t>(count));
    Elements out;
    Vector3d p = Vector3d::Zero();
    for (int i = 0; i < static_cast<int>(count); ++i) {
      const Pose X{compiler.from_euler(i * euler), p};
      p += X.R * offset;
      const Renaming to{"", separator + fmt::format("{:0{}}", i, digits)};
      for (const XmlElement& inner : e.children) {
        XmlElement& copy = out.emplace_back(inner);
        move(copy, X);
        rename(copy, to, false);
      }
      for (const auto& [section, reference] : references)
        section->children.push_back(renamed_reference(reference, to));
    }
    return out;
  }

  // Removes and returns the entries that refer to `names` only; refuses entries that refer to `names` and
  // others.
  std::vector<std::pair<XmlElement*, XmlElement>> take_references(const XmlElement& replicate,
                                                                  const TreeNames& names, Model& model) {
    std::vector<std::pair<XmlElement*, XmlElement>> out;
    const auto take = [&](XmlElement& section) {
      if (!is_referring(section)) return;
      Elements kept;
      for (XmlElement& e : section.children) {
        const Share in = names_in(e, names);
        if (in == Share::some)
          e.refuse(
              fmt::format("joins objects that <replicate> at {} copies with objects that it does not copy",
                          replicate.where()));
        if (in == Share::all)
          out.emplace_back(&section, std::move(e));
        else
          kept.push_back(std::move(e));
      }
      section.children = std::move(kept);
    };
    for (XmlElement& section : model.root.children) take(section);
    for (XmlElement& section : model.added) take(section);
    return out;
  }

  // ---- attach ----

  static const XmlElement* find(const XmlElement& in, std::string_view kind, const std::string& name) {
    for (const XmlElement& c : in.children) {
      if (c.name == kind && c.text("name") == name) return &c;
      if (c.name == "default" || c.name == "asset") continue;
      if (const XmlElement* found = find(c, kind, name)) return found;
    }
    return nullptr;
  }

  // The model that <attach> names; without `model`, this one before expansion.
  XmlElement model_named_by(const XmlElement& e, Model& model) {
    const std::string* name = e.find("model");
    if (!name) return model.before;
    for (const XmlElement& section : model.root.children) {
      if (section.name != "asset") continue;
      for (const XmlElement& asset : section.children) {
        if (asset.name != "model" || (asset.has("name") && asset.text("name") != *name)) continue;
        const XmlElement& other = load(asset);
        if (!asset.has("name") && other.text("model") != *name) continue;
        asset.read = true;
        asset.find("content_type");
        return other;
      }
    }
    e.refuse("model", fmt::format("<asset> has no model named '{}'", *name));
  }

  const XmlElement& load(const XmlElement& asset) {
    const auto file = (compilers_.of(asset).folder / asset.require("file")).lexically_normal();
    const auto known = loaded_.find(file.string());
    if (known != loaded_.end()) return known->second;
    XmlElement root = read_xml_named(asset, file);
    if (root.name != "mujoco")
      asset.refuse("file", fmt::format("{} contains <{}>, expected <mujoco>", file.string(), root.name));
    return loaded_.emplace(file.string(), prepare(std::move(root))).first->second;
  }

  Elements attached(XmlElement& e, Model& model) {
    e.read = true;
    const std::string prefix = e.require("prefix");
    const bool other = e.has("model");
    if (e.has("body") && e.has("frame")) e.refuse("has both body and frame; expected one of the two");
    const char* kind = e.has("body") ? "body" : e.has("frame") ? "frame" : nullptr;
    if (!kind && !other) e.refuse("names neither a model nor a body or frame");
    if (model.depth >= most_attached)
      e.refuse(fmt::format("models are attached to each other more than {} deep; one of them contains itself",
                           most_attached));
    XmlElement child = model_named_by(e, model);
    grow(e, 50 + count_elements(child));
    if (kind) {
      const XmlElement* const found = find(child, kind, e.require(kind));
      if (!found) e.refuse(kind, fmt::format("there is no {} named '{}'", kind, e.require(kind)));
      XmlElement world = made_from(child, "worldbody");
      world.children.push_back(*found);
      std::erase_if(child.children, [](const XmlElement& section) { return section.name == "worldbody"; });
      child.children.push_back(std::move(world));
    }
    put_together(child, model.depth + 1);
    return take_over(child, {prefix, ""}, other, kind == nullptr, model);
  }

  // Returns the children of the attached model's world; its other sections go to `model`. `other`: it is
  // another model; `whole`: all of it is attached.
  static Elements take_over(XmlElement& child, const Renaming& to, bool other, bool whole, Model& model) {
    Elements out;
    for (XmlElement& section : child.children)
      if (section.name == "worldbody")
        std::move(section.children.begin(), section.children.end(), std::back_inserter(out));
    const TreeNames names = names_of(out);
    for (XmlElement& e : out) rename(e, to, other);
    for (XmlElement& section : child.children) {
      if (is_referring(section)) {
        XmlElement& own = model.added.emplace_back(made_from(section, section.name));
        for (const XmlElement& e : section.children)
          if (names_in(e, names) == Share::all || (whole && other))
            own.children.push_back(renamed_reference(e, to));
      } else if (other && section.name == "asset") {
        XmlElement& own = model.added.emplace_back(made_from(section, section.name));
        for (const XmlElement& e : section.children) {
          if (e.name == "model") continue;
          XmlElement& asset = own.children.emplace_back(e);
          if (asset.name == "mesh" && !asset.has("name") && asset.has("file"))
            set_attribute(asset, "name", std::filesystem::path(asset.text("file")).stem().string());
          rename(asset, to, false);
        }
      } else if (other && (section.name == "tendon" || section.name == "actuator" ||
                           section.name == "deformable" || section.name == "sensor")) {
        model.added.push_back(section);
      }
    }
    return out;
  }

  void grow(const XmlElement& because, std::size_t elements) {
    elements_ += elements;
    if (elements_ > most_mjcf_elements)
      because.refuse(fmt::format("the model grows to more than {} elements", most_mjcf_elements));
    admit_xml(because.where(), elements);
  }

  MjcfCompilers compilers_;
  std::map<std::string, XmlElement> loaded_;  // models by file
  std::size_t elements_ = 0;                  // elements added so far
};

}  // namespace

MjcfModel assemble_mjcf(XmlElement root) {
  Assembler assembler;
  root = assembler.prepare(std::move(root));
  assembler.put_together(root, 0);
  return {std::move(root), assembler.take_compilers()};
}

}  // namespace borelli
