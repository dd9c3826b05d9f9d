// MuJoCo: writes the tree as MJCF and runs MuJoCo's own stepper. MuJoCo's equalities and contacts are soft;
// they get the stiffest stable reference (a time constant of two steps) and an impedance of 0.9999. A contact
// with restitution becomes a spring and damper with a half period of about twelve steps.
#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/numbers/rotation_between.hpp"
#include "peer.hpp"

namespace borelli::peers {
namespace {

using Eigen::Vector3d;

template <class Numbers>
std::string text(const Numbers& numbers) {
  std::string out;
  for (const double x : numbers) out += fmt::format("{:.17g} ", x);
  return out;
}

std::string body_name(int link) { return link < 0 ? "world" : fmt::format("l{}", link); }

class Writer {
 public:
  explicit Writer(const Tree& tree) : tree_(tree), sites_(tree.links.size() + 1) {
    for (const Spring& s : tree.springs) {
      if (s.damping != 0) complaint = "a damped spring between points";
      add_tendon(s);
    }
    for (const Ground& g : tree.grounds) add_ground(g);
  }

  std::string write() {
    // no more memory than it needs, since MuJoCo clears all of it before a run
    std::string xml = fmt::format(
        "<mujoco><compiler angle='radian' inertiafromgeom='false' autolimits='false'/>"
        "<option collision='predefined' cone='elliptic' tolerance='1e-15' iterations='200'/><size njmax='{}' "
        "nconmax='{}' "
        "nstack='{}'/>",
        3 * tree_.held.size() + 32 * tree_.grounds.size() + 10, 8 * tree_.grounds.size() + 1,
        200000 + 3000 * tree_.links.size());
    xml += "<worldbody>" + sites_.back();
    write_children(xml, -1);
    xml += "</worldbody><equality>";
    for (const Held& h : tree_.held) {
      // MuJoCo places the second body's point at zero joints; it is corrected after reading
      xml += fmt::format("<connect body1='{}' body2='{}' anchor='{}' solimp='0.9999 0.9999 0.001 0.5 2'/>",
                         body_name(h.a.link), body_name(h.b.link), text(h.a.point));
    }
    return xml + "</equality><contact>" + pairs_ + "</contact><tendon>" + tendons_ + "</tendon></mujoco>";
  }

  std::string complaint;

 private:
  std::string add_site(const At& at) {
    const std::string name = fmt::format("s{}", count_++);
    sites_[at.link < 0 ? sites_.size() - 1 : at.link] +=
        fmt::format("<site name='{}' pos='{}'/>", name, text(at.point));
    return name;
  }

  void add_tendon(const Spring& s) {
    tendons_ += fmt::format(
        "<spatial stiffness='{:.17g}' springlength='{:.17g}'><site site='{}'/><site site='{}'/></spatial>",
        s.stiffness, s.rest, add_site(s.a), add_site(s.b));
  }

  void add_ground(const Ground& g) {
    const Eigen::Matrix3d R = rotation_between(Vector3d::UnitZ(), g.normal);
    const int n = count_++;
    sites_.back() += fmt::format("<geom name='p{}' type='plane' pos='{}' quat='{}' size='0 0 1'/>", n,
                                 text(g.on), text(quaternion(R)));
    const bool box = g.radius == 0;
    sites_[g.centre.link] += fmt::format(
        "<geom name='g{}' type='{}' pos='{}' size='{}'/>", n, box ? "box" : "sphere", text(g.centre.point),
        box ? text(Vector3d(0.5 * g.size)) : fmt::format("{:.17g}", g.radius));
    pairs_ += fmt::format(
        "<pair geom1='p{0}' geom2='g{0}' condim='{1}' friction='{2} {2} 0 0 0' solimp='0.9999 0.9999 0.001 "
        "0.5 2'/>",
        n, g.friction > 0 ? 3 : 1, std::max(g.friction, 1e-5));
  }

  void write_children(std::string& xml, int parent) {
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      const Link& link = tree_.links[i];
      if (link.parent != parent) continue;
      // inertia by principal axes: MuJoCo's own diagonalisation of a tensor is good to 1e-9 only; a bar's
      // moment about itself must not be zero there
      const Vector3d moments = link.moments.cwiseMax(1e-12 * link.moments.maxCoeff());
      xml += fmt::format(
          "<body name='l{}' pos='{}' quat='{}'>{}<inertial pos='{}' quat='{}' mass='{:.17g}' "
          "diaginertia='{}'/>",
          i, text(link.p), text(quaternion(link.R)), joint(i, link), text(link.centre),
          text(quaternion(link.principal)), link.mass, text(moments));
      xml += sites_[i];
      write_children(xml, int(i));
      xml += "</body>";
    }
  }

  std::string joint(std::size_t i, const Link& link) const {
    if (link.joint == Link::Joint::free) {
      return fmt::format("<freejoint name='j{}'/>", i);
    }
    if (link.joint == Link::Joint::ball) return fmt::format("<joint name='j{}' type='ball'/>", i);
    double stiffness = 0, damping = 0, rest = 0;
    for (const JointSpring& s : tree_.joint_springs)
      if (s.link == int(i)) stiffness = s.stiffness, damping = s.damping, rest = s.rest;
    return fmt::format(
        "<joint name='j{}' type='{}' axis='{}' stiffness='{:.17g}' damping='{:.17g}' springref='{:.17g}'/>",
        i, link.joint == Link::Joint::hinge ? "hinge" : "slide", text(link.axis), stiffness, damping, rest);
  }

  const Tree& tree_;
  std::vector<std::string> sites_;  ///< sites and geoms per link, and of the world
  std::string tendons_, pairs_;
  int count_ = 0;
};

class Mujoco : public Peer {
 public:
  Mujoco(const Tree& tree, mjModel* model) : tree_(tree), model_(model), data_(mj_makeData(model)) {
    std::copy(tree.gravity.begin(), tree.gravity.end(), model->opt.gravity);
    for (std::size_t i = 0; i < tree.links.size(); ++i) {
      bodies_.push_back(mj_name2id(model, mjOBJ_BODY, fmt::format("l{}", i).c_str()));
      joints_.push_back(mj_name2id(model, mjOBJ_JOINT, fmt::format("j{}", i).c_str()));
    }
    for (std::size_t i = 0; i < tree.held.size(); ++i) {
      std::copy(tree.held[i].a.point.begin(), tree.held[i].a.point.end(), model->eq_data + mjNEQDATA * i);
      std::copy(tree.held[i].b.point.begin(), tree.held[i].b.point.end(), model->eq_data + mjNEQDATA * i + 3);
    }
  }
  ~Mujoco() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  Mujoco(const Mujoco&) = delete;
  Mujoco& operator=(const Mujoco&) = delete;

  std::string version() const override { return fmt::format("MuJoCo {}", mj_versionString()); }
  std::vector<Method> methods() const override {
    return {{"MuJoCo Euler"}, {"MuJoCo implicit"}, {"MuJoCo RK4"}};
  }

  Result<Run> run(std::size_t method, double step, double, const std::vector<double>& times,
                  const std::function<bool()>& go_on) override {
    constexpr int integrators[] = {mjINT_EULER, mjINT_IMPLICIT, mjINT_RK4};
    model_->opt.integrator = integrators[method];
    try {
      return run(method, step, times, go_on);
    } catch (const std::runtime_error& e) {
      return failure("", e.what());
    }
  }

 private:
  Result<Run> run(std::size_t method, double step, const std::vector<double>& times,
                  const std::function<bool()>& go_on) {
    start();
    Run out;
    double t = 0;
    for (const double next : times) {
      const long steps = steps_in(next - t, step);
      set_step((next - t) / double(steps));
      for (long i = 0; i < steps; ++i) {
        mj_step(model_, data_);
        if (i % 64 == 0 && !go_on()) return failure("", "took too long");
      }
      out.evaluations += steps * (method == 2 ? 4 : 1);
      t = next;
      for (const mjtWarning w : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC})
        if (data_->warning[w].number > 0) return failure("", fmt::format("diverged before t = {:.4g} s", t));
      note(out);
    }
    return out;
  }

  void start() {
    mj_resetData(model_, data_);
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      const Link& link = tree_.links[i];
      double* q = data_->qpos + model_->jnt_qposadr[joints_[i]];
      std::copy(link.q.begin(), link.q.end(), q);
      double* v = data_->qvel + model_->jnt_dofadr[joints_[i]];
      std::copy(link.v.begin(), link.v.end(), v);
      if (link.joint != Link::Joint::free) continue;  // MuJoCo's free joint is placed in the world itself
      const Vector3d p = link.R * Vector3d(link.q[0], link.q[1], link.q[2]) + link.p;
      const Vector3d u = link.R * Vector3d(link.v[0], link.v[1], link.v[2]);
      const Quaternion turn =
          product(quaternion(link.R), Quaternion(link.q[3], link.q[4], link.q[5], link.q[6]));
      std::copy(p.begin(), p.end(), q);
      std::copy(turn.begin(), turn.end(), q + 3);
      std::copy(u.begin(), u.end(), v);
    }
    for (const Turn& turn : tree_.turns)
      for (int k = 0; k < 3; ++k) data_->xfrc_applied[6 * bodies_[turn.link] + 3 + k] = turn.torque[k];
  }

  void set_step(double step) {
    model_->opt.timestep = step;
    for (int i = 0; i < model_->neq; ++i) model_->eq_solref[mjNREF * i] = 2 * step;
    for (int i = 0; i < model_->npair; ++i) {
      const double e = tree_.grounds[i].restitution, slow = std::log(std::max(e, 1e-9)), omega = 0.25 / step;
      const double damping = -slow / std::hypot(M_PI, slow);  // half a period keeps the share e of the speed
      double* reference = model_->pair_solref + mjNREF * i;
      reference[0] = e > 0 ? -omega * omega : 2 * step;
      reference[1] = e > 0 ? -2 * damping * omega : 1;
    }
  }

  void note(Run& out) {
    mj_kinematics(model_, data_);
    mj_comPos(model_, data_);
    mj_comVel(model_, data_);
    for (const int body : bodies_) {
      Moving m;
      m.R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->xmat + 9 * body);
      m.p = Eigen::Map<const Vector3d>(data_->xpos + 3 * body);
      double twist[6];
      mj_objectVelocity(model_, data_, mjOBJ_BODY, body, twist, 0);  // about the gravity centre
      m.omega = {twist[0], twist[1], twist[2]};
      m.centre = {twist[3], twist[4], twist[5]};
      out.links.push_back(m);
    }
  }

  Tree tree_;
  mjModel* model_;
  mjData* data_;
  std::vector<int> bodies_, joints_;
};

}  // namespace

Result<std::unique_ptr<Peer>> make_mujoco(const Tree& tree) {
  mju_user_warning = [](const char*) {};  // diverged runs show in their numbers
  mju_user_error = [](const char* what) { throw std::runtime_error(what); };
  const auto held = with_held_points(tree);
  if (!held) return tl::unexpected(held.error());
  Writer writer(*held);
  if (!writer.complaint.empty()) return failure("MuJoCo", "has no twin of " + writer.complaint);
  const auto path = std::filesystem::temp_directory_path() / fmt::format("borelli_{}.xml", getpid());
  std::ofstream(path) << writer.write();
  char error[1000] = "";
  mjModel* model = mj_loadXML(path.c_str(), nullptr, error, sizeof error);
  std::filesystem::remove(path);
  if (!model) return failure("MuJoCo", error);
  return std::make_unique<Mujoco>(*held, model);
}

}  // namespace borelli::peers
