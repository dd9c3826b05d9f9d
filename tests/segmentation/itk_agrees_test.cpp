// ITK as an independent program: it reads what we write, and we read what it writes.
#include <gtest/gtest.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkImageRegionIteratorWithIndex.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"

namespace borelli {
namespace {

using Image = itk::Image<short, 3>;

itk::ImageIOBase::Pointer io_for(const std::string& name) {
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return itk::MetaImageIO::New().GetPointer();
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return itk::NrrdImageIO::New().GetPointer();
  return itk::NiftiImageIO::New().GetPointer();
}

Image::Pointer to_itk(const GreyVolume& volume) {
  auto image = Image::New();
  Image::RegionType region;
  for (unsigned c = 0; c < 3; ++c) region.SetSize(c, static_cast<itk::SizeValueType>(volume.grid.size[c]));
  image->SetRegions(region);
  image->Allocate();
  Image::SpacingType spacing;
  Image::DirectionType direction;
  Image::PointType origin;
  for (int c = 0; c < 3; ++c) {
    const auto u = static_cast<unsigned>(c);
    spacing[u] = volume.grid.spacing()[c];
    origin[u] = volume.grid.origin[c];
    for (int r = 0; r < 3; ++r) direction(static_cast<unsigned>(r), u) = volume.grid.axes(r, c) / spacing[u];
  }
  image->SetSpacing(spacing), image->SetOrigin(origin), image->SetDirection(direction);
  std::copy(volume.voxels.begin(), volume.voxels.end(), image->GetBufferPointer());
  return image;
}

// the largest distance between ITK's and a grid's position of a voxel, mm
double apart(const Image& image, const Grid& grid) {
  double worst = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Image::IndexType index;
    Eigen::Vector3d ours;
    for (int c = 0; c < 3; ++c) {
      index[static_cast<unsigned>(c)] = corner >> c & 1 ? grid.size[static_cast<std::size_t>(c)] - 1 : 0;
      ours[c] = static_cast<double>(index[static_cast<unsigned>(c)]);
    }
    Image::PointType p;
    image.TransformIndexToPhysicalPoint(index, p);
    worst = std::max(worst, (grid.point(ours) - Eigen::Vector3d(p[0], p[1], p[2])).norm());
  }
  return worst;
}

struct FileCase {
  const char* name;
  bool packed;
  double tolerance;  // mm
};
void PrintTo(const FileCase& c, std::ostream* out) { *out << c.name; }

// NIfTI stores float32: three times 6e-5 mm at 1234.5 mm. NRRD and MetaImage store doubles as decimals.
class ItkAgrees : public ::testing::TestWithParam<FileCase> {};

TEST_P(ItkAgrees, OnImagesWrittenByItk) {
  ScratchFolder folder;
  for (const bool mirrored : {false, true}) {
    const GreyVolume volume = noise_volume(oblique_grid(mirrored, 0), Quantity::hu);
    auto writer = itk::ImageFileWriter<Image>::New();
    writer->SetImageIO(io_for(GetParam().name));
    writer->SetFileName(folder / GetParam().name);
    writer->SetInput(to_itk(volume));
    writer->SetUseCompression(GetParam().packed);
    writer->Update();
    const auto back = read_volume(folder / GetParam().name, {FileQuantity::hu, {}});
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->volume.voxels, volume.voxels);
    EXPECT_LT(apart(*to_itk(volume), back->volume.grid), GetParam().tolerance);
    EXPECT_TRUE(back->warnings.empty()) << back->warnings.front();
  }
}

// Text voxels, in one file with the header and in a separate file.
TEST(ItkAgrees, OnTextVoxels) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
  for (const char* name : {"a.nrrd", "a.nhdr", "a.mha", "a.mhd"}) {
    const auto io = io_for(name);
    io->SetFileTypeToASCII();
    auto writer = itk::ImageFileWriter<Image>::New();
    writer->SetImageIO(io);
    writer->SetFileName(folder / name);
    writer->SetInput(to_itk(volume));
    writer->Update();
    const auto bytes = file_bytes(folder / name);
    const std::string header(bytes.begin(), bytes.end());
    ASSERT_TRUE(header.find("encoding: raw") == std::string::npos &&
                header.find("BinaryData = True") == std::string::npos)
        << name << " is no text: " << header.substr(0, 800);
    const auto back = read_volume(folder / name, {FileQuantity::hu, {}});
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->volume.voxels, volume.voxels) << name;
    EXPECT_LT(apart(*to_itk(volume), back->volume.grid), 1e-4) << name;
  }
}

// One file per slice, which ITK reads as we do.
TEST(ItkAgrees, OnListsOfSlices) {
  ScratchFolder folder;
  const GreyVolume volume = noise_volume(oblique_grid(false, 0), Quantity::hu);
  const std::size_t slice = static_cast<std::size_t>(volume.grid.size[0] * volume.grid.size[1]);
  for (std::size_t k = 0; k < 4; ++k) {
    const char* const first = reinterpret_cast<const char*>(volume.voxels.data() + k * slice);
    put_bytes(folder / ("s" + std::to_string(10 + 5 * k) + ".raw"), {first, first + 2 * slice});
    put_bytes(folder / ("t" + std::string(k < 2 ? "00" : "0") + std::to_string(8 + k) + ".raw"),
              {first, first + 2 * slice});
  }
  for (const char* named :
       {"LIST\ns10.raw\ns15.raw\ns20.raw\ns25.raw\n", "s%d.raw 10 25 5\n", "t%03d.raw 8 11 1\n"}) {
    const std::string header = std::string("ObjectType = Image\nNDims = 3\nBinaryData = True\n") +
                               "BinaryDataByteOrderMSB = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n" +
                               "Offset = 1 2 3\nElementSpacing = 2 2.5 3\nDimSize = 5 7 4\n" +
                               "ElementType = MET_SHORT\nElementDataFile = " + named;
    put_bytes(folder / "a.mhd", {header.begin(), header.end()});
    auto reader = itk::ImageFileReader<Image>::New();
    reader->SetImageIO(io_for("a.mhd"));
    reader->SetFileName(folder / "a.mhd");
    reader->Update();
    const auto& theirs = *reader->GetOutput();
    const auto ours = read_volume(folder / "a.mhd", {FileQuantity::hu, {}});
    ASSERT_TRUE(ours) << ours.error().message();
    EXPECT_EQ(ours->volume.voxels, volume.voxels) << named;
    EXPECT_TRUE(std::equal(volume.voxels.begin(), volume.voxels.end(), theirs.GetBufferPointer())) << named;
    EXPECT_LT(apart(theirs, ours->volume.grid), 1e-9);
  }
}

TEST(ItkReads, OurFiles) {
  ScratchFolder folder;
  for (const auto& [name, packed, tolerance] :
       {FileCase{"a.nii", false, 2e-4}, FileCase{"a.nii.gz", true, 2e-4}, FileCase{"a.nrrd", true, 1e-9},
        FileCase{"a.mha", true, 1e-9}}) {
    for (const bool mirrored : {false, true}) {
      const GreyVolume volume = noise_volume(oblique_grid(mirrored, 0), Quantity::hu);
      ASSERT_TRUE(write_volume(folder / name, volume));
      auto reader = itk::ImageFileReader<Image>::New();
      reader->SetImageIO(io_for(name));
      reader->SetFileName(folder / name);
      reader->Update();
      const auto& image = *reader->GetOutput();
      ASSERT_EQ(image.GetLargestPossibleRegion().GetNumberOfPixels(), volume.grid.count());
      EXPECT_TRUE(std::equal(volume.voxels.begin(), volume.voxels.end(), image.GetBufferPointer())) << name;
      EXPECT_LT(apart(image, volume.grid), tolerance) << name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Files, ItkAgrees,
                         ::testing::Values(FileCase{"a.nii", false, 2e-4}, FileCase{"a.nii.gz", true, 2e-4},
                                           FileCase{"a.hdr", false, 2e-4}, FileCase{"a.img", false, 2e-4},
                                           FileCase{"a.img.gz", true, 2e-4}, FileCase{"a.nrrd", false, 1e-9},
                                           FileCase{"a.nrrd", true, 1e-9}, FileCase{"a.nhdr", false, 1e-9},
                                           FileCase{"a.nhdr", true, 1e-9}, FileCase{"a.mha", false, 1e-9},
                                           FileCase{"a.mha", true, 1e-9}, FileCase{"a.mhd", false, 1e-9},
                                           FileCase{"a.mhd", true, 1e-9}));

}  // namespace
}  // namespace borelli
