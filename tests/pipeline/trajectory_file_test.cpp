// A trajectory of arbitrary numbers is written and read back; h5py reads it by the layout in the header;
// damaged files are refused with one sentence.
#include "pipeline/export/trajectory_file.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>

#include "pipeline/files/hdf5_file.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

Trajectory made_up(std::size_t times) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-5, 5);
  const auto rows = [&](int columns) {
    Rows out(static_cast<Eigen::Index>(times), columns);
    for (Eigen::Index i = 0; i < out.size(); ++i) out.data()[i] = number(random);
    return out;
  };
  const auto column = [&](std::size_t n) {
    std::vector<double> out(n);
    for (double& v : out) v = number(random);
    return out;
  };
  Trajectory t;
  for (std::size_t i = 0; i < times; ++i) t.times.push_back(0.1 * static_cast<double>(i));
  t.coordinates = {{"hip, left", "ball", "thigh", 0, 4, 0, 3, true},
                   {"slide", "translation", "cube", 4, 1, 3, 1, false}};
  t.q = rows(5), t.v = rows(4), t.a = rows(4);
  t.solids = {"thigh", "cube", "lamp"};
  for (std::size_t i = 0; i < times * 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d(number(random), number(random), number(random)).normalized();
    t.poses.push_back(
        {rotation_about(axis, number(random)), {number(random), number(random), number(random)}});
  }
  t.gravity_centre = rows(3);
  t.linear_momentum = rows(3), t.angular_momentum = rows(3);
  t.reaction_points = rows(9), t.reaction_forces = rows(9), t.reaction_moments = rows(9);
  t.reaction_unique = rows(3);
  t.multiplier_names = {"pin[0]", "pin[1]"};
  t.multipliers = rows(2);
  t.contact_names = {"ground", "wall[1]", "wall[2]"};
  t.contact_modes = rows(3), t.contact_forces = rows(3);
  t.driven_positions = rows(0), t.driven_efforts = rows(0);
  t.kinetic = column(times), t.potential = column(times), t.work = column(times);
  t.step_times = column(7), t.step_sizes = column(7);
  Certificate& c = t.certificate;
  c.reason = "energy \"grew\"";
  c.reason_time = 0.25;
  c.energy_drift = 1. / 3, c.energy_turnover = 3, c.energy_threshold = 1e-6;
  c.conserved = {{"momentum along x", 1e-9, 3, 0.1}};
  c.residuals = {{"pin", 1e-12, 1e-11, 0.1, 0.2, 1e-10, 0.3}};
  c.constraint_rows = 2, c.constraint_rank = 1;
  c.nearness = 0.25, c.nearness_time = 0.5, c.singular_passages = 3, c.singular_turn = 0.125;
  c.redundant = {"pin[1]"};
  c.assembly_position = 0.125, c.assembly_position_coordinate = "knee";
  c.assembly_velocity = 5, c.assembly_velocity_coordinate = "hip";
  c.notes = {"first", "second"};
  c.events = {{0.125, "range_left", "coordinate 'knee' above 2.4"}, {0.5, "impact", "ball", 2.5, 0.75}};
  c.contacts = 3, c.impacts = 7, c.impact_loss = 0.75, c.contact_error = 0.0625;
  c.work_events = -3, c.work_events_size = 3;
  c.accuracy = 1e-6, c.estimated_error = 1e-7, c.known_until = 0.75, c.stiff_from = 0.5;
  c.step_defect = 0.03, c.step_defect_time = 0.75, c.step_defect_coordinate = "hip";
  c.steps_accepted = 1234567890123, c.steps_rejected = 4, c.evaluations = 99;
  c.smallest_step = 1e-5;
  return t;
}

class TrajectoryFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("borelli_trajectory_" + std::to_string(std::random_device{}()));
    fs::create_directories(folder_);
    path_ = folder_ / "a.h5";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void run_python(const std::string& code) {
    std::ofstream(folder_ / "run.py") << "import h5py, numpy as np, sys\n" << code;
    const std::string command = "/usr/bin/python3 " + (folder_ / "run.py").string() + " " + path_.string();
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  static bool has_h5py() { return std::system("/usr/bin/python3 -c 'import h5py, numpy' 2>/dev/null") == 0; }

  fs::path folder_, path_;
};

TEST_F(TrajectoryFile, Hdf5RoundTripsEveryNumber) {
  const Trajectory t = made_up(5);
  ASSERT_TRUE(write_trajectory(t, "name = \"s\"\n", path_));
  EXPECT_TRUE(is_trajectory(path_));
  const auto stored = read_trajectory(path_);
  ASSERT_TRUE(stored) << stored.error().message();
  const Trajectory& r = stored->trajectory;
  EXPECT_EQ(stored->scene, "name = \"s\"\n");
  EXPECT_EQ(r.times, t.times);
  EXPECT_EQ(r.q, t.q);
  EXPECT_EQ(r.v, t.v);
  EXPECT_EQ(r.a, t.a);
  ASSERT_EQ(r.coordinates.size(), 2u);
  EXPECT_EQ(r.coordinates[0].name, "hip, left");
  EXPECT_EQ(r.coordinates[1].kind, "translation");
  EXPECT_EQ(r.coordinates[1].solid, "cube");
  EXPECT_EQ(r.coordinates[1].q_index, 4);
  EXPECT_EQ(r.coordinates[0].v_size, 3);
  EXPECT_TRUE(r.coordinates[0].angle);
  EXPECT_FALSE(r.coordinates[1].angle);
  EXPECT_EQ(r.contact_names, t.contact_names);
  EXPECT_EQ(r.contact_modes, t.contact_modes);
  EXPECT_EQ(r.contact_forces, t.contact_forces);
  EXPECT_EQ(r.certificate.contacts, 3);
  EXPECT_EQ(r.certificate.impacts, 7);
  EXPECT_EQ(r.certificate.impact_loss, 0.75);
  EXPECT_EQ(r.certificate.contact_error, 0.0625);
  ASSERT_EQ(r.certificate.events.size(), 2u);
  EXPECT_EQ(r.certificate.events[1].impulse, 2.5);
  EXPECT_EQ(r.certificate.events[1].energy_lost, 0.75);
  EXPECT_EQ(r.solids, t.solids);
  ASSERT_EQ(r.poses.size(), t.poses.size());
  for (std::size_t i = 0; i < t.poses.size(); ++i) {
    EXPECT_EQ(r.poses[i].p, t.poses[i].p);
    EXPECT_LT((r.poses[i].R - t.poses[i].R).cwiseAbs().maxCoeff(),
              4e-15);  // rounding of quaternions, both ways
  }
  EXPECT_EQ(r.gravity_centre, t.gravity_centre);
  EXPECT_EQ(r.linear_momentum, t.linear_momentum);
  EXPECT_EQ(r.angular_momentum, t.angular_momentum);
  EXPECT_EQ(r.reaction_points, t.reaction_points);
  EXPECT_EQ(r.reaction_forces, t.reaction_forces);
  EXPECT_EQ(r.reaction_moments, t.reaction_moments);
  EXPECT_EQ(r.reaction_unique, t.reaction_unique);
  EXPECT_EQ(r.multiplier_names, t.multiplier_names);
  EXPECT_EQ(r.multipliers, t.multipliers);
  EXPECT_EQ(r.driven_positions.rows(), 5);
  EXPECT_EQ(r.driven_positions.cols(), 0);
  EXPECT_EQ(r.kinetic, t.kinetic);
  EXPECT_EQ(r.potential, t.potential);
  EXPECT_EQ(r.work, t.work);
  EXPECT_EQ(r.step_times, t.step_times);
  EXPECT_EQ(r.step_sizes, t.step_sizes);
}

TEST_F(TrajectoryFile, Hdf5RoundTripsTheCertificate) {
  const Trajectory t = made_up(2);
  ASSERT_TRUE(write_trajectory(t, "", path_));
  const auto stored = read_trajectory(path_);
  ASSERT_TRUE(stored) << stored.error().message();
  const Certificate &a = t.certificate, &b = stored->trajectory.certificate;
  EXPECT_FALSE(b.trusted);
  EXPECT_EQ(b.reason, a.reason);
  EXPECT_EQ(b.reason_time, a.reason_time);
  EXPECT_EQ(b.energy_drift, a.energy_drift);
  EXPECT_EQ(b.energy_threshold, a.energy_threshold);
  EXPECT_EQ(b.steps_accepted, a.steps_accepted);
  EXPECT_EQ(b.constraint_rank, 1);
  EXPECT_EQ(b.nearness, 0.25);
  EXPECT_EQ(b.nearness_time, 0.5);
  EXPECT_EQ(b.singular_passages, 3);
  EXPECT_EQ(b.singular_turn, 0.125);
  EXPECT_EQ(b.smallest_step, a.smallest_step);
  ASSERT_EQ(b.conserved.size(), 1u);
  EXPECT_EQ(b.conserved[0].name, "momentum along x");
  EXPECT_EQ(b.conserved[0].scale, 3);
  ASSERT_EQ(b.residuals.size(), 1u);
  EXPECT_EQ(b.residuals[0].constraint, "pin");
  EXPECT_EQ(b.residuals[0].velocity_time, 0.2);
  EXPECT_EQ(b.residuals[0].acceleration, 1e-10);
  EXPECT_EQ(b.residuals[0].acceleration_time, 0.3);
  EXPECT_EQ(b.redundant, a.redundant);
  EXPECT_EQ(b.notes, a.notes);
  ASSERT_EQ(b.events.size(), 2u);
  EXPECT_EQ(b.events[0].time, 0.125);
  EXPECT_EQ(b.events[0].name, "coordinate 'knee' above 2.4");
  EXPECT_EQ(b.events[1].kind, "impact");
  EXPECT_EQ(b.work_events, -3);
  EXPECT_EQ(b.accuracy, 1e-6);
  EXPECT_EQ(b.estimated_error, 1e-7);
  EXPECT_EQ(b.known_until, 0.75);
  EXPECT_EQ(b.stiff_from, 0.5);
  EXPECT_EQ(b.step_defect, 0.03);
  EXPECT_EQ(b.step_defect_time, 0.75);
  EXPECT_EQ(b.step_defect_coordinate, "hip");
  EXPECT_EQ(b.work_events_size, 3);
  EXPECT_EQ(b.assembly_position, 0.125);
  EXPECT_EQ(b.assembly_position_coordinate, "knee");
  EXPECT_EQ(b.assembly_velocity, 5);
  EXPECT_EQ(b.assembly_velocity_coordinate, "hip");
}

TEST_F(TrajectoryFile, IsReadByAnotherProgramByTheStatedLayout) {
  if (!has_h5py()) GTEST_SKIP() << "needs python3 with h5py and numpy";
  const Trajectory t = made_up(4);
  ASSERT_TRUE(write_trajectory(t, "name = \"s\"\n", path_));
  std::ostringstream expected;
  expected.precision(17);
  expected
      << "f = h5py.File(sys.argv[1])\n"
      << "assert f.attrs['format'] == 'borelli trajectory'\n"
      << "assert f['scene'][0].decode() == 'name = \"s\"\\n'\n"
      << "assert f['time'].attrs['units'] == 's' and f['energy/kinetic'].attrs['units'] == 'J'\n"
      << "assert f['q'].shape == (4, 5) and f['q'][3, 4] == " << t.q(3, 4) << "\n"
      << "assert f['solids/position'].shape == (4, 3, 3) and f['solids/position'].attrs['units'] == 'm'\n"
      << "assert f['solids/position'][2, 1, 0] == " << t.pose(2, 1).p[0] << "\n"
      << "assert [n.decode() for n in f['solids/name']] == ['thigh', 'cube', 'lamp']\n"
      << "w, x, y, z = f['solids/orientation'][2, 1]\n"
      << "R = np.array([[1-2*(y*y+z*z), 2*(x*y-w*z), 2*(x*z+w*y)], [2*(x*y+w*z), 1-2*(x*x+z*z), "
         "2*(y*z-w*x)],\n"
      << "              [2*(x*z-w*y), 2*(y*z+w*x), 1-2*(x*x+y*y)]])\n"
      << "assert abs(R[0, 1] - " << t.pose(2, 1).R(0, 1) << ") < 1e-14\n"
      << "assert abs(R[2, 0] - " << t.pose(2, 1).R(2, 0) << ") < 1e-14\n"
      << "assert f['certificate'].attrs['steps_accepted'] == 1234567890123\n"
      << "assert f['certificate'].attrs['reason'] == 'energy \"grew\"'\n";
  run_python(expected.str());
}

TEST_F(TrajectoryFile, OrientationsDoNotJumpInSign) {
  Trajectory t = made_up(9);
  for (std::size_t i = 0; i < 9; ++i)  // a slow full turn: w changes sign on the way
    t.poses[3 * i].R = rotation_about(Eigen::Vector3d::UnitX(), 2 * M_PI / 8 * static_cast<double>(i));
  ASSERT_TRUE(write_trajectory(t, "", path_));
  const auto q = Hdf5Reader::open(path_)->numbers("/solids/orientation");
  ASSERT_TRUE(q);
  for (std::size_t i = 1; i < 9; ++i)
    EXPECT_NEAR(q->values[12 * i], std::cos(M_PI / 8 * static_cast<double>(i)), 1e-14);
}

TEST_F(TrajectoryFile, CsvContainsEveryNumberUnderItsName) {
  const Trajectory t = made_up(3);
  const fs::path csv = folder_ / "a.csv";
  ASSERT_TRUE(write_trajectory(t, "", csv));
  std::ifstream file(csv);
  std::string line;
  std::getline(file, line);
  EXPECT_TRUE(line.starts_with("time [s],\"q hip, left.w [1]\",")) << line;
  EXPECT_NE(line.find("q slide [m],"), std::string::npos);
  EXPECT_NE(line.find("v slide [m/s],"), std::string::npos);
  EXPECT_NE(line.find("position lamp.z [m],orientation lamp.w [1]"), std::string::npos);
  EXPECT_TRUE(line.ends_with(",trusted [1]")) << line;
  for (int i = 0; i < 3; ++i) {
    std::getline(file, line);
    std::istringstream cells(line);
    std::vector<double> values;
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    ASSERT_EQ(values.size(), 1u + 5 + 4 + 4 + 4 + 3 + 6 + 2 + 2 * 3 + 3 * 7 + 3 * 10 + 1);
    EXPECT_EQ(values[0], t.times[static_cast<std::size_t>(i)]);
    EXPECT_EQ(values[5], t.q(i, 4));
    EXPECT_EQ(values[14], t.kinetic[static_cast<std::size_t>(i)]);
    EXPECT_EQ(values[16], values[14] + values[15]);
    EXPECT_EQ(values[21], t.linear_momentum(i, 0));
    EXPECT_EQ(values[26], t.angular_momentum(i, 2));
    EXPECT_EQ(values[29], t.contact_modes(i, 0));
    EXPECT_EQ(values[32], t.contact_forces(i, 0));
    EXPECT_EQ(values[35 + 7], t.pose(static_cast<std::size_t>(i), 1).p[0]);
    EXPECT_EQ(values[56 + 10], t.reaction_points(i, 3));
    EXPECT_EQ(values[56 + 13], t.reaction_forces(i, 3));
    EXPECT_EQ(values[56 + 18], t.reaction_moments(i, 5));
    EXPECT_EQ(values[56 + 19], t.reaction_unique(i, 1));
    EXPECT_EQ(values.back(), t.certificate.trusted ? 1 : 0);
  }
  EXPECT_FALSE(std::getline(file, line));
}

TEST_F(TrajectoryFile, EndingChoosesTheFormat) {
  const auto done = write_trajectory(made_up(1), "", folder_ / "a.xyz");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, Error::Kind::use);
  EXPECT_FALSE(write_trajectory(made_up(1), "", folder_ / "none" / "a.csv"));
  EXPECT_FALSE(write_trajectory(made_up(1), "", folder_ / "none" / "a.h5"));
}

TEST_F(TrajectoryFile, TruncatedFilesAreRefusedInOneSentence) {
  ASSERT_TRUE(write_trajectory(made_up(5), "", path_));
  std::ifstream file(path_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 40) {
    std::ofstream(folder_ / "cut.h5", std::ios::binary) << bytes.substr(0, length);
    const auto answer = read_trajectory(folder_ / "cut.h5");
    ASSERT_FALSE(answer) << length;
    EXPECT_NE(answer.error().message().find("cut.h5"), std::string::npos);
  }
}

// HDF5 1.10 itself crashes or hangs on some of these.
TEST_F(TrajectoryFile, DamagedFilesAreRefusedWithoutACrashOrAHang) {
  ASSERT_TRUE(write_trajectory(made_up(5), "", path_));
  std::ifstream file(path_, std::ios::binary);
  const std::string sealed{std::istreambuf_iterator<char>(file), {}};
  const std::string plain = sealed.substr(0, sealed.size() - 81);  // as from a program that writes no digest
  std::mt19937 random(1);
  const auto mutate = [&](std::string bytes) {
    for (int n = 1 + static_cast<int>(random() % 8); n > 0; --n) {
      const std::size_t at = random() % bytes.size();
      switch (random() % 4) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
          break;
        case 1:
          bytes[at] = static_cast<char>(random());
          break;
        case 2:
          bytes[at] = random() % 2 ? '\xff' : '\0';
          break;
        default:  // moves a part of it elsewhere
          const std::size_t count = std::min<std::size_t>(random() % 64, bytes.size() - at);
          bytes.replace(at, count, bytes.substr(random() % (bytes.size() - count), count));
      }
    }
    return bytes;
  };
  const fs::path damaged = folder_ / "damaged.h5";
  const auto read = [&](const std::string& bytes) {
    std::ofstream(damaged, std::ios::binary) << bytes;
    const auto from = std::chrono::steady_clock::now();
    auto answer = read_trajectory(damaged);
    EXPECT_LT(std::chrono::steady_clock::now() - from, std::chrono::seconds(8));
    EXPECT_TRUE(answer || answer.error().message().find("damaged.h5") != std::string::npos);
    return answer;
  };
  for (int n = 0; n < 2000; ++n) {
    std::string bytes = mutate(sealed);
    if (bytes == sealed) continue;
    bytes.replace(bytes.size() - 81, 81, sealed.substr(sealed.size() - 81));
    EXPECT_TRUE(bytes == sealed || !read(bytes)) << n;
  }
  int refused = 0;
  for (int n = 0; n < 400; ++n) refused += !read(mutate(plain));
  EXPECT_GT(refused, 20);
  EXPECT_LT(refused, 400);  // a changed number is not always detectable
}

TEST_F(TrajectoryFile, FileThatHangsHdf5IsRefusedAtOnce) {
  const fs::path hang = fs::path(test::shared_folder()) / "cases/hang.h5";
  if (!fs::exists(hang)) GTEST_SKIP() << "needs the shared folder's cases";
  const auto from = std::clock();
  const auto answer = read_trajectory(hang);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().what.find("is damaged: reading it as HDF5 "), std::string::npos)
      << answer.error().message();
  EXPECT_LT(static_cast<double>(std::clock() - from) / CLOCKS_PER_SEC, 1);
}

TEST_F(TrajectoryFile, OddFilesAreRefusedWithTheArraysName) {
  if (!has_h5py()) GTEST_SKIP() << "needs python3 with h5py and numpy";
  const std::pair<const char*, const char*> edits[] = {
      {"del f['q']", "/q is missing"},
      {"del f['energy/work']; f['energy/work'] = np.zeros(4)", "/energy/work has 4 entries, expected 5"},
      {"del f['v']; f['v'] = np.zeros(5)", "/v has 1 dimensions, expected 2"},
      {"del f['solids/position']; f['solids/position'] = np.zeros((5, 2, 3))", "one pose per time and solid"},
      {"f['solids/orientation'][0, 0] = [0, 0, 0, 0]", "not of unit length"},
      {"f['coordinates/q_index'][1] = 9", "slide lies outside"},
      {"f['coordinates/q_index'][1] = float('nan')", "expected a whole number"},
      {"del f['certificate'].attrs['trusted']", "trusted of /certificate is missing"},
      {"f['certificate'].attrs['trusted'] = 'yes'", "is not a single number"},
      {"del f['solids/name']; f['solids/name'] = [1., 2., 3.]", "does not contain texts"},
      {"f.attrs['version'] = 7.", "version 7, but this program reads version 1"},
      {"f.attrs['format'] = 'other'", "not a trajectory"}};
  for (const auto& [edit, said] : edits) {
    ASSERT_TRUE(write_trajectory(made_up(5), "", path_));
    run_python("f = h5py.File(sys.argv[1], 'r+')\n" + std::string(edit) + "\n");
    const auto answer = read_trajectory(path_);
    ASSERT_FALSE(answer) << edit;
    EXPECT_NE(answer.error().message().find(said), std::string::npos)
        << edit << ": " << answer.error().message();
  }
}

}  // namespace
}  // namespace borelli
