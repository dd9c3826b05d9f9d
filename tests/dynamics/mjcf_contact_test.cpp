// Contacts read from MJCF: against MuJoCo (pairs, friction, depth), against the same human in TOML, and
// against closed forms. Also the note on pairs without contact that pass through each other.
#include "dynamics/formats/mjcf_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "dynamics/formats/model_file.hpp"
#include "scenes.hpp"
#include "test_folder.hpp"
#include "tests/paths.hpp"

#ifdef BORELLI_MUJOCO
#include "mujoco_model.hpp"
#endif

namespace borelli::test {
namespace {

ModelFile read_text(const std::string& xml) {
  const Folder folder;
  return need(read_model(folder.write("m.xml", xml)));
}

std::string over_floor(const std::string& bodies, const std::string& floor = "") {
  return "<mujoco><worldbody><geom name='floor' type='plane' size='1 1 1' " + floor + "/>" + bodies +
         "</worldbody></mujoco>";
}

/// Two bodies with this geom, 2 m apart along x, each moving at 1 m/s towards the other.
ModelFile two_that_meet(const std::string& geom) {
  ModelFile out = read_text(
      "<mujoco><option gravity='0 0 0'/><worldbody><body name='a'><joint name='x' type='slide' axis='1 0 0'/>"
      "<geom " +
      geom + "/></body><body name='b' pos='2 0 0'><joint name='y' type='slide' axis='-1 0 0'/><geom " + geom +
      "/></body></worldbody></mujoco>");
  for (Solid& solid : out.scene.solids)
    for (Switch& one : solid.switches)
      if (!one.coordinate.empty()) one.v = {1};
  return out;
}

Trajectory drop(const ModelFile& model, const std::string& method, double end, double step) {
  SimulationSettings how = model.scene.simulation;
  how.method = method;
  how.end_time = end;
  how.step = step;
  return run(model.scene, how);
}

/// Time of the first row at which the free fall has ended.
double first_touch(const Trajectory& path) {
  for (Eigen::Index row = 1; row < path.v.rows(); ++row)
    if (path.v(row, 2) > path.v(row - 1, 2)) return path.times[std::size_t(row)];
  return -1;
}

TEST(MjcfContacts, FallingBodyHitsThePlaneOnTimeAndRests) {
  // a level floor at 0.2 m; the box stands on a corner
  const struct {
    const char* geom;
    double under;  // from the body's origin to its lowest point
  } cases[] = {{"<geom size='.1'/>", 0.1},
               {"<geom type='box' size='.1 .2 .15'/>", 0.15},
               {"<geom type='box' size='.1 .2 .15' euler='90 0 0'/>", 0.2},
               {"<geom type='capsule' fromto='-.1 0 -.05 .1 0 -.05' size='.05'/>", 0.1}};
  for (const auto& [geom, under] : cases) {
    const ModelFile model = read_text(
        over_floor("<body pos='0 0 1'><freejoint/>" + std::string(geom) + "</body>", "pos='0 0 .2'"));
    EXPECT_TRUE(model.not_modelled.empty()) << geom;
    EXPECT_EQ(model.scene.simulation.method, "moreau");
    EXPECT_EQ(model.scene.simulation.step, 2e-3);  // MuJoCo's own
    const double fall = std::sqrt(2 * (0.8 - under) / 9.81);
    const Trajectory stepped = drop(model, "moreau", 1, 2e-3), located = drop(model, "rk4_adaptive", 1, 2e-3);
    EXPECT_NEAR(first_touch(stepped), fall, 2e-3) << geom;  // at the end of the step of the contact
    EXPECT_NEAR(first_touch(located), fall, 1e-9) << geom;  // by event location
    // overlaps are separated up to a millionth of the bodies' size
    EXPECT_NEAR(last(stepped.q)[2], 0.2 + under, 1e-6) << geom;
    EXPECT_NEAR(last(located.q)[2], 0.2 + under, 1e-9) << geom;
    EXPECT_TRUE(stepped.certificate.trusted) << stepped.certificate.reason;
    EXPECT_TRUE(located.certificate.trusted) << located.certificate.reason;
  }
}

TEST(MjcfContacts, BlockOnATiltedPlaneFollowsTheGeomFriction) {
  // the larger friction (0.3) counts, unless the other geom has priority; condim 1 has no friction
  const double tilt = 0.5, g = 9.81;
  const auto slides = [&](const std::string& block, double friction) {
    const ModelFile model = read_text(
        "<mujoco><compiler angle='radian'/><worldbody><geom type='plane' size='1 1 1' euler='0 .5 0' "
        "friction='.3' condim='1'/><body euler='0 .5 0' pos='.0479425538604 0 .0877582561890'><freejoint/>"
        "<geom type='box' size='.2 .2 .1' " +
        block + "/></body></worldbody></mujoco>");
    const Trajectory path = drop(model, "moreau", 1, 1e-3);
    const double a = g * (std::sin(tilt) - friction * std::cos(tilt));
    const Vector3d direction(std::cos(tilt), 0, -std::sin(tilt)),
        from = model.scene.solids[0].switches.empty() ? Vector3d::Zero() : Vector3d(path.q.row(0).head<3>());
    EXPECT_NEAR((Vector3d(last(path.q).head<3>()) - from).dot(direction), a / 2, 1e-5) << block;
  };
  slides("friction='.2'", 0.3);
  slides("friction='.2' priority='1'", 0.2);
  slides("friction='.2' priority='1' condim='1'", 0);
  slides("friction='.4' priority='-1' condim='3'", 0);  // the floor's condim is 1
}

TEST(MjcfContacts, HumanEqualsThatOfTheSceneFile) {
  const std::filesystem::path path = shared_folder() + "/models/bench/human_contact.xml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Scene model = need(read_model(path)).scene;
  const Scene scene = need(read_model(source_folder() + "/tests/bench/human_floor.toml")).scene;
  std::erase_if(model.constraints, [](const Constraint& c) {  // contacts between its own parts
    return std::holds_alternative<SphereOverSphere>(c.kind) ||
           std::holds_alternative<CapsuleOverCapsule>(c.kind);
  });
  const System a = compiled(model), b = compiled(scene);
  EXPECT_LT((a.initial.q - b.initial.q).cwiseAbs().maxCoeff(), 1e-15);
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  EXPECT_EQ(a.contacts.size(), 26u);
  EXPECT_EQ(model.simulation.method, "moreau");
  EXPECT_EQ(model.simulation.step, 2e-3);
  // equal up to rounding until it lands; then to the accuracy of impulses (1e-8 of velocities), which grows
  // as it folds
  SimulationSettings how = settings("moreau", 0.1, 2e-3);
  EXPECT_LT((last(run(a, how).q) - last(run(b, how).q)).cwiseAbs().maxCoeff(), 1e-12);
  how.end_time = 0.4;
  EXPECT_LT((last(run(a, how).q) - last(run(b, how).q)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(MjcfContacts, PassingThroughIsReportedWithTime) {
  // switched-off contacts are judged like missing ones
  const auto path_of = [](const ModelFile& model, double end, double step) {
    Trajectory path = drop(model, "rk4", end, step);
    EXPECT_TRUE(path.certificate.trusted);
    return path;
  };
  const auto judged = [&](double end) {
    const ModelFile model = read_text(
        over_floor("<body name='b' pos='0 0 1'><freejoint/><geom type='cylinder' size='.1 .2'/></body>",
                   "contype='0' conaffinity='0'"));
    Trajectory path = path_of(model, end, 1e-3);
    judge_passing({{{.name = "geom 'floor'", .solid = world_name, .plane = Plane{}, .core = {}},
                    {.name = "geom 'tin'",
                     .solid = "b",
                     .plane = {},
                     .core = core_of(model.scene.solids[0].shapes[0].shape)}},
                   {{0, 1}}},
                  path);
    return path.certificate;
  };
  // a cylinder of radius .1, whose lowest point is .2 below its origin, falls 0.8 m
  const double touch = std::sqrt(2 * 0.8 / 9.81);
  EXPECT_TRUE(judged(touch).trusted);
  const Certificate c = judged(touch + 0.01);
  EXPECT_FALSE(c.trusted);
  EXPECT_NEAR(c.reason_time, touch, 2e-3);
  EXPECT_EQ(c.reason.find("geom 'floor' and geom 'tin' overlap at t = 0.40"), 0u) << c.reason;
  // two boxes that meet in the middle: a gap of 1 m, 1 m/s each
  ModelFile boxes = two_that_meet("type='box' size='.5 .5 .5'");
  ASSERT_EQ(boxes.scene.constraints.size(), 1u);
  boxes.scene.constraints.clear();
  Trajectory path = path_of(boxes, 1, 1e-2);
  const auto core = core_of(boxes.scene.solids[0].shapes[0].shape);
  judge_passing({{{.name = "a", .solid = "a", .plane = {}, .core = core},
                  {.name = "b", .solid = "b", .plane = {}, .core = core}},
                 {{0, 1}}},
                path);
  EXPECT_NEAR(path.certificate.reason_time, 0.51, 1e-9);  // deeper than 5 mm at the next row
}

TEST(MjcfContacts, GeomsCollide) {
  for (const char* geom : {"size='.5'", "type='capsule' size='.5 .2'", "type='box' size='.5 .4 .3'",
                           "type='ellipsoid' size='.5 .4 .3'", "type='cylinder' size='.5 .3'"}) {
    const ModelFile model = two_that_meet(geom);
    EXPECT_TRUE(model.without_contact.pairs.empty());
    EXPECT_EQ(model.scene.simulation.method, "moreau");
    SimulationSettings how = model.scene.simulation;
    how.end_time = 1;
    const Trajectory path = run(model.scene, how);
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    // without rebound they stay together, each 0.5 m from its start
    EXPECT_NEAR(path.certificate.impact_loss, path.kinetic[0], 1e-9 * path.kinetic[0]);
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(last(path.q)[i], 0.5, 1e-9) << geom;
  }
}

TEST(MjcfContacts, TooManyPairsAreReported) {
  std::string balls;
  for (int i = 0; i < 80; ++i) balls += "<body><freejoint/><geom size='.1'/></body>";
  const ModelFile model = read_text(over_floor(balls));
  EXPECT_EQ(model.scene.constraints.size(), 80u);
  EXPECT_EQ(model.without_contact.pairs.size(), 80u * 79 / 2);
  EXPECT_EQ(model.not_modelled.motion[0].find("contacts of 3160 pairs of geoms"), 0u)
      << model.not_modelled.motion[0];
}

// A box of 1 kg slides down a plane of 30 degrees: g (sin - mu cos), or it stays.
TEST(MjcfContacts, OptionOverridesFriction) {
  const auto speed = [](const std::string& option, const std::string& pair) {
    ModelFile model = read_text(
        "<mujoco><option gravity='4.905 0 -8.4957' " + option +
        "</option><worldbody><geom name='floor' type='plane' size='5 5 1'/><body pos='0 0 .1'><freejoint/>"
        "<geom name='box' type='box' size='.2 .2 .1' mass='1'/></body></worldbody>" +
        pair + "</mujoco>");
    EXPECT_TRUE(model.not_modelled.motion.empty()) << model.not_modelled.motion[0];
    SimulationSettings how = model.scene.simulation;
    how.end_time = 0.5;
    const Trajectory path = run(model.scene, how);
    return path.v(path.v.rows() - 1, 0);
  };
  const std::string enabled = "><flag override='enable'/>", disabled = ">",
                    pair = "<contact><pair geom1='floor' geom2='box' friction='.1 .1'/></contact>";
  const double slides = 0.5 * (4.905 - 0.1 * 8.4957);
  EXPECT_NEAR(speed("o_friction='.1 .1 .005'" + enabled, ""), slides, 1e-3);
  EXPECT_NEAR(speed("o_friction='.1 .1 .005'" + disabled, ""), 0, 1e-9);
  EXPECT_NEAR(speed(disabled, pair), slides, 1e-3);
  EXPECT_NEAR(speed("o_friction='1 1'" + enabled, pair), 0, 1e-9);
}

TEST(MjcfContacts, FrictionByDirectionIsNamed) {
  for (const auto& [pair, named] : {std::pair{"friction='.1 .5'", true},
                                    {"friction='.1'", true},  // default 1
                                    {"friction='.3 .3 .1'", false},
                                    {"", false},
                                    {"condim='1' friction='.1 .5'", false}}) {
    const ModelFile model = read_text(over_floor("<body><freejoint/><geom name='ball' size='.1'/></body>")
                                          .replace(0, 8,
                                                   "<mujoco><contact><pair geom1='floor' geom2='ball' " +
                                                       std::string(pair) + "/></contact>"));
    ASSERT_EQ(model.not_modelled.motion.size(), named ? 1u : 0u) << pair;
    if (!named) continue;
    EXPECT_TRUE(model.not_modelled.motion[0].starts_with("friction that differs by direction of 1 pairs"))
        << model.not_modelled.motion[0];
  }
}

TEST(MjcfContacts, OverlapsAtTheStartAreSeparated) {
  const ModelFile model =
      read_text(over_floor("<body name='b' pos='0 0 .05'><freejoint/><geom size='.1'/></body>"));
  SimulationSettings how = model.scene.simulation;
  how.end_time = 0.1;
  const Trajectory path = run(model.scene, how);
  EXPECT_NEAR(path.q(0, 2), 0.1, 1e-9);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  ASSERT_FALSE(path.certificate.notes.empty());
  EXPECT_EQ(path.certificate.notes[0],
            "contact 'b over floor' overlapped by 0.05 m at the start; it was separated by the smallest "
            "move, mostly of coordinate 'b.z', by 0.05 m");
}

TEST(MjcfContacts, ImpossibleContactsAreRefused) {
  const Folder folder;
  const auto refused = [&](const std::string& xml, const std::string& part) {
    const auto model = read_model(folder.write("m.xml", xml));
    ASSERT_FALSE(model) << xml;
    EXPECT_NE(model.error().message().find(part), std::string::npos) << model.error().message();
  };
  refused(over_floor("<body><freejoint/><geom size='1' condim='2'/></body>"), "expected 1, 3, 4 or 6");
  refused(over_floor("<body><freejoint/><geom size='1'/><geom type='plane' size='1 1 1'/></body>"),
          "a plane of a moving body");
  refused(over_floor("<body><freejoint/><geom size='1' friction='-1'/></body>"), "is negative");
  refused("<mujoco><worldbody/><contact><exclude body1='a'/></contact></mujoco>", "body2");
  refused(
      "<mujoco><worldbody><geom name='a' size='1'/></worldbody><contact><pair geom1='a' "
      "geom2='b'/></contact></mujoco>",
      "there is no geom named 'b'");
}

TEST(MjcfContacts, SegmentDistanceIsTheSmallest) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Vector3d(number(engine), number(engine), number(engine)); };
  for (int trial = 0; trial < 50; ++trial) {
    const Vector3d a = point(), a_end = trial % 5 == 0 ? a : point(), b = point(),
                   b_end = trial % 7 == 0 ? Vector3d(b + a_end - a) : point();
    double least = 1e9;
    constexpr int n = 200;
    for (int i = 0; i <= n; ++i)
      for (int k = 0; k <= n; ++k)
        least = std::min(least, (a + i * (a_end - a) / n - b - k * (b_end - b) / n).norm());
    const double found = segment_distance(a, a_end, b, b_end);
    EXPECT_LE(found, least + 1e-12);
    EXPECT_GE(found, least - ((a_end - a).norm() + (b_end - b).norm()) / (2 * n));
  }
}

#ifdef BORELLI_MUJOCO

// A contact: the two names, friction (0 if none) and depth. `searched`: both programs find it by iteration,
// not by a closed form.
struct Touch {
  double friction = 0, depth = 0;
  bool searched = false;
};
using Touches = std::map<std::pair<std::string, std::string>, Touch>;

std::pair<std::string, std::string> sorted(const std::string& a, const std::string& b) {
  return {std::min(a, b), std::max(a, b)};
}

Touches of_mujoco(Mujoco& mujoco) {
  mujoco.model->opt.disableflags &= ~(mjDSBL_CONSTRAINT | mjDSBL_CONTACT);
  mj_kinematics(mujoco.model, mujoco.data);
  mj_comPos(mujoco.model, mujoco.data);
  mj_collision(mujoco.model, mujoco.data);
  Touches out;
  for (int i = 0; i < mujoco.data->ncon; ++i) {
    const mjContact& c = mujoco.data->contact[i];
    const auto name = [&](int geom) { return std::string(mj_id2name(mujoco.model, mjOBJ_GEOM, geom)); };
    const auto weld = [&](int geom) { return mujoco.model->body_weldid[mujoco.model->geom_bodyid[geom]]; };
    if (weld(c.geom1) == weld(c.geom2)) continue;  // a <pair> within one rigid body has no effect
    const auto [found, first] = out.try_emplace(sorted(name(c.geom1), name(c.geom2)));
    Touch& touch = found->second;
    // geoms that a <pair> names and the masks allow have both contacts, the <pair>'s first
    if (first) touch.friction = c.dim == 1 ? 0 : c.friction[0];
    touch.depth = std::max(touch.depth, -c.dist);
  }
  return out;
}

// Our contacts that touch in a state.
Touches of_contacts(const ModelFile& model, const System& system, const State& state) {
  Workspace w(system);
  EXPECT_FALSE(accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, w));
  ConstraintRows every(system);
  every.every_row = true;
  scan_constraints(system, system.parameters, w.kinematics, every);
  Touches out;
  for (const Contact& contact : system.contacts) {
    const Constraint& constraint = model.scene.constraints[std::size_t(contact.constraint)];
    const std::string name = constraint.name.substr(0, constraint.name.find('\''));
    const auto middle = name.find(" over ");
    const double depth = -every.h[contact.row];
    if (depth <= 0) continue;
    Touch& touch = out[sorted(name.substr(0, middle), name.substr(middle + 6))];
    touch.depth = std::max(touch.depth, depth);
    touch.searched = std::holds_alternative<ConvexOverConvex>(constraint.kind);
    std::visit(
        [&](const auto& kind) {
          if constexpr (requires { kind.surface.friction; }) touch.friction = kind.surface.friction;
        },
        constraint.kind);
  }
  return out;
}

// A random tree with all geoms around the origin, so that all allowed pairs touch.
std::string random_heap(unsigned seed) {
  std::mt19937 engine(seed);
  const auto pick = [&](int n) { return int(engine() % unsigned(n)); };
  const auto number = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(engine);
  };
  int geoms = 0;
  const auto attributes = [&] {
    const char* condims[] = {"1", "3", "4", "6"};
    return fmt::format(
        " name='g{}' contype='{}' conaffinity='{}' priority='{}' condim='{}' friction='{:.3f} .1 .1' "
        "euler='{} "
        "{} {}' pos='{:.3f} {:.3f} {:.3f}'",
        geoms++, pick(4), pick(4), pick(2), condims[pick(4)], number(0.1, 1), pick(180), pick(180), pick(180),
        number(-.02, .02), number(-.02, .02), number(-.02, .02));
  };
  const auto geom = [&] {
    const char* forms[] = {"'sphere' size='.3'", "'capsule' size='.25 .1'", "'box' size='.3 .25 .2'",
                           "'cylinder' size='.3 .25'", "'ellipsoid' size='.2 .25 .3'"};
    return fmt::format("<geom type={} {}/>", forms[pick(5)], attributes());
  };
  const auto plane = [&] { return fmt::format("<geom type='plane' size='1 1 1' {}/>", attributes()); };
  constexpr int bodies = 8;
  std::vector<std::string> inner(bodies + 1);
  for (int i = bodies; i > 0; --i) {
    std::string body = fmt::format("<body name='b{}'>", i);
    // only static bodies may have a plane
    if (i == 1)
      body += plane();
    else if (pick(4) > 0)
      body += "<joint type='ball'/>";
    body += geom() + (pick(2) ? geom() : "") + inner[std::size_t(i)] + "</body>";
    inner[std::size_t(i == 1 ? 0 : pick(i))] += body;
  }
  std::string contact;
  for (int i = 0; i < 3; ++i)
    contact += fmt::format("<exclude body1='b{}' body2='b{}'/>", 1 + pick(4), 5 + pick(4));
  contact += fmt::format("<exclude body1='world' body2='b{}'/>", 2 + pick(7));
  for (int i = 0; i < 2; ++i)
    contact += fmt::format("<pair geom1='g{}' geom2='g{}' {}/>", pick(geoms / 2), geoms / 2 + pick(geoms / 2),
                           i == 0 ? "" : "condim='4' friction='.35 .35 .1 .1 .1'");
  const char* collision[] = {"all", "all", "predefined", "dynamic"};
  // bodies without a geom, because MuJoCo's space for pairs depends on the number of bodies
  for (int i = 0; i < 12; ++i) inner[0] += "<body/>";
  return fmt::format(
      "<mujoco><option collision='{}'><flag filterparent='{}'/></option><size nconmax='2000' njmax='10'/>"
      "<worldbody>{}{}{}</worldbody><contact>{}</contact></mujoco>",
      collision[pick(4)], pick(3) ? "enable" : "disable", plane(), geom(), inner[0], contact);
}

TEST(MjcfContacts, PairsThatMayTouchEqualMujocos) {
  int contacts = 0, searched = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Folder folder;
    const std::string xml = random_heap(seed);
    const auto path = folder.write("m.xml", xml);
    const ModelFile model = need(read_model(path));
    const System system = compiled(model.scene);
    Mujoco mujoco(path);
    const Touches expected = of_mujoco(mujoco);
    const Touches own = of_contacts(model, system, system.initial);
    for (const auto& [pair, touch] : own) {
      const auto found = expected.find(pair);
      ASSERT_NE(found, expected.end()) << pair.first << " " << pair.second << "\n" << xml;
      EXPECT_NEAR(touch.friction, found->second.friction, 1e-15) << xml;
      if (touch.searched) {
        EXPECT_GT(touch.depth, 0);  // both depths are local minima
        ++searched;
      } else {
        EXPECT_NEAR(touch.depth, found->second.depth, 1e-12) << pair.first << " " << pair.second << "\n"
                                                             << xml;
        ++contacts;
      }
    }
    EXPECT_TRUE(model.without_contact.pairs.empty());
    for (const auto& [pair, touch] : expected)
      EXPECT_TRUE(own.contains(pair)) << pair.first << " " << pair.second << "\n" << xml;
    EXPECT_EQ(own.size(), expected.size()) << xml;
  }
  EXPECT_GT(contacts, 200);
  EXPECT_GT(searched, 300);
}

TEST(MjcfContacts, HumanContactsEqualMujocos) {
  const std::filesystem::path path = shared_folder() + "/models/bench/human_contact.xml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  // its geoms have no names, so MuJoCo's are identified by body
  const ModelFile model = need(read_model(path));
  const System system = compiled(model.scene);
  Mujoco mujoco(path);
  mujoco.model->opt.disableflags &= ~(mjDSBL_CONSTRAINT | mjDSBL_CONTACT);
  Random random(2);
  int on_floor = 0, on_itself = 0;
  for (int trial = 0; trial < 20; ++trial) {
    State state = random.state(system);
    state.q[2] = random.number(0, 1);
    state.v.setZero();
    std::copy(state.q.begin(), state.q.end(), mujoco.data->qpos);
    mj_fwdPosition(mujoco.model, mujoco.data);
    std::map<std::pair<std::string, std::string>, double> deepest;
    for (int i = 0; i < mujoco.data->ncon; ++i) {
      const mjContact& c = mujoco.data->contact[i];
      const auto name = [&](int geom) -> std::string {
        if (mujoco.model->geom_type[geom] == mjGEOM_PLANE) return "plane";
        return mj_id2name(mujoco.model, mjOBJ_BODY, mujoco.model->geom_bodyid[geom]);
      };
      double& depth = deepest[sorted(name(c.geom1), name(c.geom2))];
      depth = std::max(depth, -c.dist);
    }
    const Touches own = of_contacts(model, system, state);
    EXPECT_EQ(own.size(), deepest.size());
    for (const auto& [pair, touch] : own) {
      EXPECT_NEAR(touch.depth, deepest[pair], 1e-12) << pair.first << " " << pair.second;
      ++(pair.first == "plane" || pair.second == "plane" ? on_floor : on_itself);
    }
  }
  EXPECT_GT(on_floor, 50);
  EXPECT_GT(on_itself, 20);
}

TEST(MjcfContacts, BallLandsWhenMujocosDoes) {
  const Folder folder;
  const auto path = folder.write(
      "m.xml",
      "<mujoco><option timestep='1e-4'/><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 "
      ".5'><freejoint/><geom size='.1'/></body></worldbody></mujoco>");
  const double touch = first_touch(run(need(read_model(path)).scene));
  Mujoco mujoco(path);
  mujoco.model->opt.disableflags &= ~(mjDSBL_CONSTRAINT | mjDSBL_CONTACT);
  while (mujoco.data->ncon == 0 && mujoco.data->time < 1) mj_step(mujoco.model, mujoco.data);
  EXPECT_NEAR(touch, mujoco.data->time, 3e-4);  // MuJoCo's Euler falls g t h / 2 too far, less than a step
  while (mujoco.data->time < 1) mj_step(mujoco.model, mujoco.data);
  // MuJoCo's floor yields under the weight
  EXPECT_NEAR(last(run(need(read_model(path)).scene).q)[2], mujoco.data->qpos[2], 1e-3);
}

#endif

}  // namespace
}  // namespace borelli::test
