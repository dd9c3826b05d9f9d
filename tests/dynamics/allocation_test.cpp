// No method allocates inside a step: all allocations are counted while it steps a constrained scene.
#include <cerrno>
#include <cstdlib>

#include "allocation_count.hpp"
#include "dynamics/equations/state_derivatives.hpp"
#include "dynamics/methods/motion_flow.hpp"
#include "dynamics/run/step_path.hpp"
#include "scenes.hpp"

#ifdef BORELLI_COUNTS_ALLOCATIONS
std::atomic<long> borelli::test::allocation_count = 0;

namespace {
bool counting = false;
long allocations = 0;

void count_one() {
  borelli::test::allocation_count.fetch_add(1, std::memory_order_relaxed);
  if (counting) ++allocations;
}
}  // namespace

// all allocation functions (The GNU C Library's manual, Replacing malloc), except those that return pages
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  count_one();
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  count_one();
  return __libc_calloc(count, size);
}

void* realloc(void* old, std::size_t size) {
  count_one();
  return __libc_realloc(old, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  count_one();
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }

int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  void* const made = memalign(alignment, size);
  if (!made) return ENOMEM;
  *out = made;
  return 0;
}
}
#endif

namespace borelli::test {
namespace {

#ifdef BORELLI_COUNTS_ALLOCATIONS

/// Allocations in `steps` steps, after ten steps that may allocate.
long allocations_in(const System& system, const std::string& method, int steps) {
  SimulationSettings how;
  Workspace workspace(system), probe(system);
  MotionFlow motion(system, how, workspace);
  const auto integrator = need(make_integrator(method, 1e-6));
  StepPath path(system, how, motion, *integrator, &probe);
  Landing landing(system);
  landing.state = system.initial;
  need(assemble(system, system.parameters, landing.state, workspace));
  Eigen::VectorXd y(motion.size()), dy(motion.size()), out(motion.size());
  Work work = landing.work;
  const double h = 1e-3;
  for (int i = 0; i < 10 + steps; ++i) {
    counting = i >= 10;
    const double t = landing.state.t;
    bool fine = motion.start(landing.state, landing.work, y, dy);
    const Attempt attempt = integrator->attempt(motion, t, h, y, dy, out);
    fine = fine && attempt.evaluated;
    work = landing.work;
    path.begin(t, h, y, dy, out, work);
    fine = fine && path.land_at_end(t + h, landing).has_value();
    counting = false;
    EXPECT_TRUE(fine) << method;
  }
  return std::exchange(allocations, 0);
}

TEST(Allocations, NoMethodAllocatesWhileStepping) {
  // a ball joint, a hinge and a rod that closes the loop; and a ball that rests on a floor
  Scene scene;
  scene.solids = {solid("upper", "world", {ball("shoulder")}, {inertial(2, {0.3, 0, 0}, {0.01, 0.1, 0.1})}),
                  solid("lower", "upper", {fixed({0.6, 0, 0}), hinge("elbow", Vector3d::UnitY(), 1)},
                        {inertial(1, {0.2, 0, 0}, {0.01, 0.05, 0.05})})};
  scene.constraints = {{"rod", Distance{{"lower", {0.4, 0, 0}}, {"world", {0.3, 0.5, 0.2}}, constant(1)}}};
  Solid marble = solid("marble", "world", free_switches("marble"), {inertial(1, {0, 0, 0}, {1, 1, 1})});
  marble.switches[2].q = {0.1};
  scene.solids.push_back(marble);
  SphereOverPlane floor;
  floor.sphere = {"marble", {0, 0, 0}};
  floor.radius = 0.1;
  floor.plane.on = {"world", {0, 0, 0}};
  floor.surface.friction = 0.5;
  scene.constraints.push_back({"floor", floor});
  const System system = compiled(scene);
  for (const std::string& method : integrator_names()) {
    if (method == "cvode" || method == "arkode") continue;  // SUNDIALS allocates
    EXPECT_EQ(allocations_in(system, method, 20), 0) << method;
  }
  counting = true;  // the count works for both kinds of allocation
  Eigen::VectorXd* const one = new Eigen::VectorXd(100);
  void* volatile cleared = std::calloc(8, 8);
  void* volatile in_line = std::aligned_alloc(64, 64);
  counting = false;
  EXPECT_EQ(std::exchange(allocations, 0), 4);
  std::free(in_line);
  std::free(cleared);
  delete one;
}

TEST(Allocations, DerivativesAllocateOnlyAtFirst) {
  for (const bool held : {false, true}) {
    Scene scene = random_tree(4, {.balls = true, .drives = true});
    scene.efforts = {{"stops", LimitSpring{{"c51"}, 20, 0.3, {{-0.1, 0.1}, {-0.1, 0.2}, {-0.05, 0.05}}}},
                     {"scalar", PdController{{"c40"}, 30, 2, {Sine{}}}},
                     {"air", Drag{{"s3", {0.1, 0, 0.2}}, 0.3, 0.4}},
                     {"spring", PointSpring{{"s3", {0.1, 0, 0.2}}, {"s5", {0, 0, 0}}, 20, 1, 0.3}}};
    if (held)
      scene.constraints = {{"rod", Distance{{"s5", {0.4, 0, 0}}, {"world", {0.3, 0.5, 0.2}}, constant(1)}},
                           {"gear", CoordinateCoupling{{{"c40"}, {"c00"}}, {1, -2}, constant(0)}}};
    const System system = compiled(scene);
    Workspace workspace(system);
    StateDerivatives derivatives(system);
    for (int i = 0; i < 3; ++i) {
      State state = Random(unsigned(i)).state(system);
      counting = i > 0;
      const Fault unsolved =
          accelerate(system, system.parameters, state.t, state.q.data(), state.v.data(), {}, workspace);
      const Fault undone = find_acceleration_derivatives(system, system.parameters, state.t, state.q.data(),
                                                         state.v.data(), workspace, derivatives);
      counting = false;
      EXPECT_FALSE(unsolved || undone) << held;
    }
    EXPECT_EQ(std::exchange(allocations, 0), 0) << held;
  }
}

#endif

}  // namespace
}  // namespace borelli::test
