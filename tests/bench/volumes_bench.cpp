// Wall time of the work on a volume around its moments (moments_bench), by one thread and by all. Reading,
// coarsening, distances and connected regions are compared with ITK's filters; segmentation and meshing have
// no counterpart in ITK.
//
// The volume is the sample phantom with voxels and a work grid of 3 mm. The two programs differ in a few
// points. `distance_to_20` finds integer squared distances up to 20 voxels, as segmentation does;
// `distance_far` finds all; ITK (Maurer) also finds those within the mask, in floats. `coarser` averages
// along the patient's axes, ITK over two voxels along each axis of the scan. DICOM is 150 slices of 512 x
// 512, plain and compressed (JPEG lossless); ITK gets the files in order, while ours finds the order. Each
// file is decompressed by one thread; its voxels are processed by all.
#include <fmt/core.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <itkBinShrinkImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkGDCMImageIO.h>
#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkImageSeriesReader.h>
#include <itkMultiThreaderBase.h>
#include <itkNiftiImageIO.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <sched.h>

#include <filesystem>
#include <random>

#include "pipeline/export/mesh.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/body/body_mask.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/grid/squared_distances.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/volume/held_memory.hpp"
#include "tests/bench/peer_ratios.hpp"
#include "tests/segmentation/dicom_series.hpp"

namespace borelli {
namespace {

constexpr double step = 3;  // voxel size of the scan and of the work grid, mm

template <class T>
using Image = itk::Image<T, 3>;

template <class T>
typename Image<T>::Pointer itk_image(const Volume<T>& volume) {
  auto image = Image<T>::New();
  typename Image<T>::SizeType size;
  for (unsigned a = 0; a < 3; ++a) size[a] = static_cast<itk::SizeValueType>(volume.grid.size[a]);
  image->SetRegions(typename Image<T>::RegionType(size));
  image->Allocate();
  std::copy(volume.voxels.begin(), volume.voxels.end(), image->GetBufferPointer());
  return image;
}

/// A series of slices in its own folder, in order.
struct Series {
  std::filesystem::path folder;
  std::vector<std::string> files;
};

/// Writes `slices` slices of 512 x 512 from the volume's middle.
Series write_series(const Volume<std::int16_t>& volume, const std::filesystem::path& folder, int slices) {
  std::filesystem::create_directories(folder);
  Series series{folder, {}};
  TestSlice slice;
  slice.rows = slice.columns = 512, slice.is_signed = true, slice.bits_stored = 16, slice.intercept = 0;
  slice.pixels.resize(512 * 512);
  const auto& [nx, ny, nz] = volume.grid.size;
  for (int n = 0; n < slices; ++n) {
    for (std::int64_t j = 0; j < 512; ++j)
      for (std::int64_t i = 0; i < 512; ++i)
        slice.pixels[static_cast<std::size_t>(512 * j + i)] =
            static_cast<std::uint16_t>(volume.at(nx * i / 512, ny * j / 512, nz * n / slices));
    slice.instance = fmt::format("1.2.3.1.{}", n + 1);
    slice.position.z() = 5.0 * n;
    series.files.push_back(folder / fmt::format("{:04}.dcm", n));
    write_slice(series.files.back(), slice);
  }
  return series;
}

Series packed(const Series& plain, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  Series series{folder, {}};
  for (const std::string& file : plain.files) {
    gdcm::ImageReader reader;
    reader.SetFileName(file.c_str());
    if (!reader.Read()) throw std::runtime_error("GDCM cannot read " + file);
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(gdcm::TransferSyntax::JPEGLosslessProcess14_1);
    change.SetInput(reader.GetImage());
    if (!change.Change()) throw std::runtime_error("GDCM cannot pack " + file);
    gdcm::ImageWriter writer;
    writer.SetFile(reader.GetFile());
    writer.SetImage(change.GetOutput());
    series.files.push_back(folder / std::filesystem::path(file).filename());
    writer.SetFileName(series.files.back().c_str());
    if (!writer.Write()) throw std::runtime_error("GDCM cannot write " + series.files.back());
  }
  return series;
}

/// The phantom in the forms that the benchmarks use.
struct Looked {
  Scan scan;
  WorkVolume work;
  Mask body;
  Image<std::int16_t>::Pointer grey;
  Image<std::uint8_t>::Pointer mask;
  std::filesystem::path folder, file;
  Series slices, packed_slices;

  Looked() {
    const Phantom phantom = build_phantom({}).value();
    GridOptions grid;
    grid.spacing.setConstant(step);
    scan = voxelise(phantom, phantom_grid(phantom, grid), {});
    work = resampled(scan.grey, step);
    body = body_mask(work);
    grey = itk_image<std::int16_t>(scan.grey);
    mask = itk_image<std::uint8_t>(body);
    folder = std::filesystem::temp_directory_path() / fmt::format("volumes_bench_{}", std::random_device()());
    std::filesystem::create_directories(folder);
    file = folder / "phantom.nii.gz";
    if (auto done = write_volume(file.string(), scan.grey); !done)
      throw std::runtime_error(done.error().message());
    slices = write_series(scan.grey, folder / "slices", 150);
    packed_slices = packed(slices, folder / "packed");
  }
  ~Looked() {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
  Looked(const Looked&) = delete;
  Looked& operator=(const Looked&) = delete;
};

using Do = void (*)(const Looked&, int threads);

template <class Filter, class Input>
auto filtered(const Input& input) {
  auto filter = Filter::New();
  filter->SetInput(input);
  return filter;
}

void read(const Looked& l, int) {
  if (!read_volume(l.file.string(), {})) throw std::runtime_error("the volume cannot be read");
}
void itk_read(const Looked& l, int) {
  auto reader = itk::ImageFileReader<Image<std::int16_t>>::New();
  reader->SetImageIO(itk::NiftiImageIO::New());
  reader->SetFileName(l.file.string());
  reader->Update();
}

void read_series(const Series& series) {
  if (!read_volume(series.folder.string(), {})) throw std::runtime_error("the slices cannot be read");
}
void itk_read_series(const Series& series) {
  auto reader = itk::ImageSeriesReader<Image<std::int16_t>>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(series.files);
  reader->Update();
}
void dicom(const Looked& l, int) { read_series(l.slices); }
void itk_dicom(const Looked& l, int) { itk_read_series(l.slices); }
void dicom_packed(const Looked& l, int) { read_series(l.packed_slices); }
void itk_dicom_packed(const Looked& l, int) { itk_read_series(l.packed_slices); }

void coarser(const Looked& l, int threads) {
  benchmark::DoNotOptimize(resampled(l.scan.grey, 2 * step, threads));
}
void itk_coarser(const Looked& l, int) {
  const auto filter = filtered<itk::BinShrinkImageFilter<Image<std::int16_t>, Image<std::int16_t>>>(l.grey);
  filter->SetShrinkFactors(2);
  filter->Update();
}

void distance_to_20(const Looked& l, int threads) {
  benchmark::DoNotOptimize(squared_distances<std::uint16_t>(l.body, 400, {.threads = threads}));
}
void distance_far(const Looked& l, int threads) {
  benchmark::DoNotOptimize(squared_distances<std::uint32_t>(l.body, 1U << 30, {.threads = threads}));
}
void itk_distance(const Looked& l, int) {
  const auto filter =
      filtered<itk::SignedMaurerDistanceMapImageFilter<Image<std::uint8_t>, Image<float>>>(l.mask);
  filter->SetSquaredDistance(true);
  filter->SetUseImageSpacing(false);
  filter->Update();
}

void regions(const Looked& l, int threads) {
  benchmark::DoNotOptimize(connected_regions(l.body, 6, threads));
}
void itk_regions(const Looked& l, int) {
  filtered<itk::ConnectedComponentImageFilter<Image<std::uint8_t>, Image<std::int32_t>>>(l.mask)->Update();
}

void find_parts(const Looked& l, int threads) {
  if (!segment(l.scan.grey, {.step = step, .threads = threads}))
    throw std::runtime_error("no parts were found");
}
void meshes(const Looked& l, int threads) {
  if (!part_meshes(l.scan.labels, {.threads = threads})) throw std::runtime_error("there are no meshes");
}

void run(benchmark::State& bench, const Looked& looked, Do what, int threads) {
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(threads > 0 ? unsigned(threads)
                                                                      : std::thread::hardware_concurrency());
  // confines code that starts its own threads to one core
  cpu_set_t all, first;
  sched_getaffinity(0, sizeof all, &all);
  CPU_ZERO(&first);
  for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&first) == 0; ++core)
    if (CPU_ISSET(core, &all)) CPU_SET(core, &first);
  if (threads == 1) sched_setaffinity(0, sizeof first, &first);
  for (auto _ : bench) what(looked, threads);
  sched_setaffinity(0, sizeof all, &all);
}

}  // namespace
}  // namespace borelli

int main(int argc, char** argv) {
  using namespace borelli;
  hold_freed_memory();  // as the program does
  benchmark::Initialize(&argc, argv);
  itk::MultiThreaderBase::New();  // the first one fixes ITK's number of threads
  const Looked looked;
  const auto add = [&](const std::string& name, Do what, int threads) {
    benchmark::RegisterBenchmark(name.c_str(), run, std::cref(looked), what, threads)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  };
  const auto both = [&](const std::string& name, Do ours, Do itk) {
    for (const int threads : {1, 0}) {
      const std::string title = name + (threads == 1 ? "/one_core" : "/all_cores");
      add(title, ours, threads);
      if (itk) add(title + "/itk", itk, threads);
    }
  };
  both("read", read, itk_read);
  both("read_dicom", dicom, itk_dicom);
  both("read_dicom_packed", dicom_packed, itk_dicom_packed);
  both("coarser", coarser, itk_coarser);
  both("distance_to_20", distance_to_20, itk_distance);
  both("distance_far", distance_far, itk_distance);
  both("regions", regions, itk_regions);
  both("find_parts", find_parts, nullptr);
  both("meshes", meshes, nullptr);
  PeerRatios ratios("itk");
  benchmark::RunSpecifiedBenchmarks(&ratios);
}
