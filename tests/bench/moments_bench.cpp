// Moments of 16 labels of a 512 x 512 x 256 volume on one thread, compared with ITK's label statistics and
// with a plain read of the same bytes. ITK sums less: order 0, and orders 1 and 2 for the second filter.
//
// Two volumes: `body`, an elliptic body of 16 parts that fills 40 % of its box, and `full`, where every voxel
// is in a part; and `body` of up to 2000 slices. ITK runs on a 256 x 256 x 128 cut of them, since it takes
// long. All report voxels of the volume per second.
#include <benchmark/benchmark.h>
#include <itkImage.h>
#include <itkLabelImageToStatisticsLabelMapFilter.h>
#include <itkLabelStatisticsImageFilter.h>
#include <itkMultiThreaderBase.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "inertia/moments.hpp"
#include "segmentation/volume/held_memory.hpp"

namespace {

using namespace borelli;

struct Scan {
  LabelMap labels;
  GreyVolume grey;
};

Scan make_scan(std::int64_t nx, std::int64_t ny, std::int64_t nz, bool full) {
  Scan scan;
  scan.labels.grid.size = scan.grey.grid.size = {nx, ny, nz};
  scan.labels.voxels.resize(scan.labels.grid.count());
  scan.grey.voxels.resize(scan.labels.grid.count());
  std::mt19937 random(1);
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j)
      for (std::int64_t i = 0; i < nx; ++i) {
        const double x = (2. * static_cast<double>(i) + 1) / static_cast<double>(nx) - 1;
        const double y = (2. * static_cast<double>(j) + 1) / static_cast<double>(ny) - 1;
        const bool inside = full || x * x / 0.64 + y * y / 0.4 < 1;  // pi/4 sqrt(.64 * .4) = 40 %
        // 16 parts: four along x, four along z
        const auto part = 1 + std::clamp<std::int64_t>(4 * i / nx, 0, 3) + 4 * (4 * k / nz);
        scan.labels.at(i, j, k) = static_cast<std::uint8_t>(inside ? part : 0);
        // CT numbers of soft tissue with noise, some fat and bone; air outside
        const auto draw = random();
        const int tissue = (draw & 0xf00) == 0 ? 700 : (draw & 0x7000) == 0 ? -100 : 40;
        scan.grey.at(i, j, k) =
            static_cast<std::int16_t>((inside ? tissue : -1000) + static_cast<int>(draw & 63));
      }
  return scan;
}

const Scan& scan_of(int full) {
  static const Scan scans[2] = {make_scan(512, 512, 256, false), make_scan(512, 512, 256, true)};
  return scans[full];
}
const Scan& small_scan_of(int full) {
  static const Scan scans[2] = {make_scan(256, 256, 128, false), make_scan(256, 256, 128, true)};
  return scans[full];
}

void report(benchmark::State& state, const Scan& scan) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scan.labels.grid.count()));
  state.SetLabel(state.range(0) ? "full" : "body");
}

// A streaming read of the same labels and grey values: the fastest that memory allows.
__attribute__((target_clones("avx512f", "avx2", "default"))) std::uint64_t sum_words(
    const std::uint64_t* words, std::size_t count) {
  std::uint64_t total = 0;
  for (std::size_t n = 0; n < count; ++n) total += words[n];
  return total;
}

template <class T>
std::uint64_t sum_bytes(const std::vector<T>& voxels) {
  return sum_words(reinterpret_cast<const std::uint64_t*>(voxels.data()), voxels.size() * sizeof(T) / 8);
}

void read_bytes(benchmark::State& state) {
  const Scan& scan = scan_of(static_cast<int>(state.range(0)));
  const auto read = [&] {
    benchmark::DoNotOptimize(sum_bytes(scan.labels.voxels) + sum_bytes(scan.grey.voxels));
  };
  read();  // the first read of cold pages is many times slower
  for (auto _ : state) read();
  report(state, scan);
}

GreyWeights densities() {
  GreyWeights weights(65536);
  for (int g = -32768; g < 32768; ++g) weights[static_cast<std::size_t>(g + 32768)] = std::max(0., 1000. + g);
  return weights;
}

void sum(const Scan& scan, const GreyWeights& weights) {
  benchmark::DoNotOptimize(label_moments(scan.labels, scan.grey, weights, 1));
}

void borelli_moments(benchmark::State& state) {
  const Scan& scan = scan_of(static_cast<int>(state.range(0)));
  const GreyWeights weights = densities();
  sum(scan, weights);
  for (auto _ : state) sum(scan, weights);
  report(state, scan);
}

// Moments of 512 x 512 x n voxels: the slices of `body`, repeated.
void moments_of_size(benchmark::State& state) {
  const Scan& body = scan_of(0);
  Scan scan = body;
  const auto lengthen = [&](auto& to, const auto& from) {
    to.grid.size[2] = state.range(0);
    to.voxels.resize(to.grid.count());
    for (std::size_t n = 0; n < to.voxels.size(); n += from.voxels.size())
      std::copy_n(from.voxels.begin(), std::min(from.voxels.size(), to.voxels.size() - n),
                  to.voxels.begin() + static_cast<std::ptrdiff_t>(n));
  };
  lengthen(scan.labels, body.labels);
  lengthen(scan.grey, body.grey);
  const GreyWeights weights = densities();
  sum(scan, weights);
  for (auto _ : state) sum(scan, weights);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scan.labels.grid.count()));
}

template <class T>
typename itk::Image<T, 3>::Pointer itk_image(const Volume<T>& volume) {
  auto image = itk::Image<T, 3>::New();
  typename itk::Image<T, 3>::SizeType size;
  for (unsigned a = 0; a < 3; ++a) size[a] = static_cast<itk::SizeValueType>(volume.grid.size[a]);
  image->SetRegions(typename itk::Image<T, 3>::RegionType(size));
  image->Allocate();
  std::copy(volume.voxels.begin(), volume.voxels.end(), image->GetBufferPointer());
  return image;
}

using Grey = itk::Image<std::int16_t, 3>;
using Label = itk::Image<std::uint8_t, 3>;

void itk_label_statistics(benchmark::State& state) {
  const Scan& scan = small_scan_of(static_cast<int>(state.range(0)));
  const auto grey = itk_image<std::int16_t>(scan.grey);
  const auto labels = itk_image<std::uint8_t>(scan.labels);
  for (auto _ : state) {
    auto filter = itk::LabelStatisticsImageFilter<Grey, Label>::New();
    filter->SetInput(grey);
    filter->SetLabelInput(labels);
    filter->Update();
    benchmark::DoNotOptimize(filter->GetSum(1));
  }
  report(state, scan);
}

void itk_label_image_to_statistics_label_map(benchmark::State& state) {
  const Scan& scan = small_scan_of(static_cast<int>(state.range(0)));
  const auto grey = itk_image<std::int16_t>(scan.grey);
  const auto labels = itk_image<std::uint8_t>(scan.labels);
  for (auto _ : state) {
    auto filter = itk::LabelImageToStatisticsLabelMapFilter<Label, Grey>::New();
    filter->SetInput(labels);
    filter->SetFeatureImage(grey);
    filter->SetComputeHistogram(false);
    filter->SetComputePerimeter(false);
    filter->Update();
    benchmark::DoNotOptimize(filter->GetOutput()->GetNumberOfLabelObjects());
  }
  report(state, scan);
}

BENCHMARK(read_bytes)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(borelli_moments)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(moments_of_size)
    ->Unit(benchmark::kMillisecond)
    ->Arg(64)
    ->Arg(128)
    ->Arg(256)
    ->Arg(512)
    ->Arg(1000)
    ->Arg(2000);
BENCHMARK(itk_label_statistics)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(itk_label_image_to_statistics_label_map)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

// Collects each benchmark's rate and prints the ratios at the end.
class Ratios : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      if (run.aggregate_name.empty() || run.aggregate_name == "median")
        rates[run.run_name.function_name + " " + run.report_label] = run.counters.at("items_per_second");
  }
  void Finalize() override {
    for (const char* volume : {"body", "full"}) {
      const double ours = rates[std::string("borelli_moments ") + volume];
      if (ours <= 0) continue;
      GetOutputStream() << volume << ": borelli_moments " << ours * 1e-9 << " Gvoxel/s on one thread\n";
      for (const auto& [name, rate] : rates)
        if (name.ends_with(volume) && rate != ours)
          GetOutputStream() << "  ratio to " << name << " (" << rate * 1e-9 << " Gvoxel/s): " << ours / rate
                            << "\n";
    }
  }

 private:
  std::map<std::string, double> rates;
};

}  // namespace

int main(int argc, char** argv) {
  borelli::hold_freed_memory();  // as the program does
  itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(1);
  benchmark::Initialize(&argc, argv);
  Ratios ratios;
  benchmark::RunSpecifiedBenchmarks(&ratios);
}
