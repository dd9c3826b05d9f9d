// HDF5 files written and read back, read by h5py as an independent program, and refused when damaged.
#include "pipeline/files/hdf5_file.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <thread>

namespace borelli {
namespace {

namespace fs = std::filesystem;

class Hdf5File : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("borelli_hdf5_" + std::to_string(std::random_device{}()));
    fs::create_directories(folder_);
    path_ = folder_ / "a.h5";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_sample() {
    Hdf5Writer file(path_);
    file.numbers("/a/b/numbers", {2, 3}, numbers_.data(), "m/s");
    file.numbers("/nothing", {0, 3}, nullptr, "m");
    file.texts("/names", {"one", "zwei — zwo", ""});
    file.attribute("/", "format", "sample");
    file.attribute("/a", "pi", 3.141592653589793);
    const auto done = file.close();
    ASSERT_TRUE(done) << done.error().message();
  }

  const std::vector<double> numbers_{0.1, -1e-300, 1. / 3, std::numeric_limits<double>::infinity(),
                                     -0., 1e22};
  fs::path folder_, path_;
};

TEST_F(Hdf5File, RoundTrips) {
  write_sample();
  const auto file = Hdf5Reader::open(path_);
  ASSERT_TRUE(file) << file.error().message();
  const auto numbers = file->numbers("/a/b/numbers");
  ASSERT_TRUE(numbers) << numbers.error().message();
  EXPECT_EQ(numbers->shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(numbers->values, numbers_);
  EXPECT_EQ(file->numbers("/nothing")->shape, (std::vector<std::size_t>{0, 3}));
  EXPECT_EQ(*file->texts("/names"), (std::vector<std::string>{"one", "zwei — zwo", ""}));
  EXPECT_EQ(*file->text_attribute("/", "format"), "sample");
  EXPECT_EQ(*file->text_attribute("/a/b/numbers", "units"), "m/s");
  EXPECT_EQ(*file->number_attribute("/a", "pi"), 3.141592653589793);
  EXPECT_TRUE(file->holds("/a/b"));
  EXPECT_FALSE(file->holds("/a/c/numbers"));
}

TEST_F(Hdf5File, SameContentGivesTheSameBytes) {
  const auto bytes = [&] {
    write_sample();
    std::ifstream file(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string once = bytes();
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5 counts seconds
  EXPECT_EQ(bytes(), once);
}

TEST_F(Hdf5File, NamesMissingAndMismatchedObjects) {
  write_sample();
  const auto file = Hdf5Reader::open(path_);
  ASSERT_TRUE(file);
  EXPECT_NE(file->numbers("/q").error().message().find("/q is missing"), std::string::npos);
  EXPECT_NE(file->numbers("/names").error().message().find("does not contain numbers"), std::string::npos);
  EXPECT_NE(file->numbers("/a").error().message().find("not an array"), std::string::npos);
  EXPECT_NE(file->texts("/a/b/numbers").error().message().find("does not contain texts"), std::string::npos);
  EXPECT_FALSE(file->text_attribute("/a", "pi"));
  EXPECT_FALSE(file->number_attribute("/", "format"));
  EXPECT_FALSE(file->number_attribute("/", "pi"));
}

TEST_F(Hdf5File, IsReadByAnotherProgram) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "needs python3 with h5py";
  write_sample();
  const fs::path script = folder_ / "read.py";
  std::ofstream(script)
      << "import h5py, sys\n"
         "f = h5py.File(sys.argv[1])\n"
         "a = f['a/b/numbers']\n"
         "assert a.shape == (2, 3) and a.attrs['units'] == 'm/s'\n"
         "assert a[0, 0] == 0.1 and a[0, 1] == -1e-300 and a[1, 2] == 1e22\n"
         "assert [n.decode() for n in f['names']] == ['one', 'zwei — zwo', '']\n"
         "assert f.attrs['format'] == 'sample' and f['a'].attrs['pi'] == 3.141592653589793\n";
  EXPECT_EQ(std::system(("/usr/bin/python3 " + script.string() + " " + path_.string()).c_str()), 0);
}

TEST_F(Hdf5File, ReadsCompressedSinglesOfAnotherProgram) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "needs python3 with h5py";
  const fs::path script = folder_ / "write.py";
  std::ofstream(script)
      << "import h5py, numpy, sys\n"
         "f = h5py.File(sys.argv[1], 'w')\n"
         "f.create_dataset('x', data=numpy.arange(4000, dtype='f4').reshape(2000, 2), compression=9)\n"
         "f.create_dataset('i', data=numpy.array([1, 2, 3], dtype='>i2'))\n";
  ASSERT_EQ(std::system(("/usr/bin/python3 " + script.string() + " " + path_.string()).c_str()), 0);
  const auto file = Hdf5Reader::open(path_);
  ASSERT_TRUE(file);
  const auto x = file->numbers("/x");
  ASSERT_TRUE(x) << x.error().message();
  EXPECT_EQ(x->shape, (std::vector<std::size_t>{2000, 2}));
  EXPECT_EQ(x->values[3999], 3999);
  EXPECT_EQ(file->numbers("/i")->values, (std::vector<double>{1, 2, 3}));
}

TEST_F(Hdf5File, EndsWithADigestUntilAnotherProgramChangesIt) {
  write_sample();
  std::stringstream whole;
  whole << std::ifstream(path_, std::ios::binary).rdbuf();
  const std::string bytes = whole.str(), seal = bytes.substr(bytes.size() - 81);
  EXPECT_TRUE(seal.starts_with("\nborelli sha256 ") && seal.ends_with("\n")) << seal;
  const std::string sum = "head -c " + std::to_string(bytes.size() - 81) + " " + path_.string() +
                          " | sha256sum | grep -q " + seal.substr(16, 64);
  EXPECT_EQ(std::system(sum.c_str()), 0);
  const auto reads = [&] {
    return Hdf5Reader::read(path_, [](const Hdf5Reader& file) -> Result<void> {
      const auto numbers = file.numbers("/a/b/numbers");
      if (!numbers) return tl::unexpected(numbers.error());
      return numbers->values[0] == 0.1 || numbers->values[0] == 7 ? Result<void>() : failure("", "changed");
    });
  };
  EXPECT_TRUE(reads());
  std::string other = bytes;
  for (const std::size_t at : {std::size_t{9}, bytes.size() / 2, bytes.size() - 30}) {
    other[at] ^= 1;
    std::ofstream(path_, std::ios::binary) << other;
    const auto answer = reads();
    ASSERT_FALSE(answer) << at;
    EXPECT_NE(answer.error().what.find("is damaged: its bytes differ from those written"), std::string::npos);
    other[at] ^= 1;
  }
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "h5py (python3-h5py) is not there to change the file";
  std::ofstream(path_, std::ios::binary) << bytes;
  const fs::path script = folder_ / "change.py";
  std::ofstream(script) << "import h5py, sys\nh5py.File(sys.argv[1], 'r+')['a/b/numbers'][0, 0] = 7\n";
  ASSERT_EQ(std::system(("/usr/bin/python3 " + script.string() + " " + path_.string()).c_str()), 0);
  EXPECT_TRUE(reads());
}

TEST_F(Hdf5File, RefusesCutAndForeignFiles) {
  write_sample();
  std::stringstream whole;
  whole << std::ifstream(path_, std::ios::binary).rdbuf();
  const std::string bytes = whole.str();
  const fs::path cut = folder_ / "cut.h5";
  for (std::size_t length = 0; length + 81 < bytes.size(); length += 1 + length / 7) {
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, length);
    const auto answer = Hdf5Reader::read(cut, [](const Hdf5Reader& file) -> Result<void> {
      const auto names = file.texts("/names");
      return names ? Result<void>() : tl::unexpected(names.error());
    });
    EXPECT_FALSE(answer) << length << " of " << bytes.size() << " bytes";
  }
  std::ofstream(cut) << "time,q\n0,1\n";
  EXPECT_EQ(Hdf5Reader::open(cut).error().kind, Error::Kind::use);
  EXPECT_EQ(Hdf5Reader::open(folder_ / "none.h5").error().kind, Error::Kind::use);
  EXPECT_FALSE(Hdf5Reader::open(folder_));
}

TEST_F(Hdf5File, ReportsUnwritablePaths) {
  Hdf5Writer file(folder_ / "missing" / "a.h5");
  file.numbers("/x", {1}, numbers_.data(), "m");
  const auto done = file.close();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message().find("cannot be written"), std::string::npos);
}

}  // namespace
}  // namespace borelli
