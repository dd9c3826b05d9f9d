// Writes series of DICOM slices for tests with GDCM's writer; the struct below holds a slice's contents.
#pragma once

#include <fmt/format.h>
#include <gdcmAnonymizer.h>
#include <gdcmAttribute.h>
#include <gdcmImageWriter.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>

#include <Eigen/Core>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace borelli {

struct TestSlice {
  std::string series = "1.2.3.1", instance;
  std::string modality = "CT", description = "body", acquisition = "1",
              image_type = "ORIGINAL\\PRIMARY\\AXIAL";
  std::string patient_position, patient_sex, patient_age;
  int columns = 6, rows = 5;
  Eigen::Vector3d position{-10, -20, 30}, along_row{1, 0, 0}, along_column{0, 1, 0};
  double column_spacing = 0.75, row_spacing = 0.5;
  double slope = 1, intercept = -1024;
  std::string slope_text, intercept_text;                      ///< override the numbers, as text
  bool scaled = true;                                          ///< false: no slope and no intercept
  std::string position_text, pixel_spacing_text;               ///< likewise
  std::string thickness, spacing_between, location, diameter;  ///< as text; empty: omitted
  std::optional<std::uint16_t> padding;                        ///< stored value
  bool is_signed = false;
  int bits_stored = 12;
  int frames = 1;                     ///< stated, without pixels
  std::vector<std::uint16_t> pixels;  ///< row by row
};

inline void write_slice(const std::string& path, const TestSlice& s) {
  gdcm::Trace::WarningOff();
  gdcm::ImageWriter writer;
  gdcm::Image& image = writer.GetImage();
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(s.columns));
  image.SetDimension(1, static_cast<unsigned>(s.rows));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  const auto bits = static_cast<unsigned short>(s.bits_stored);
  image.SetPixelFormat(gdcm::PixelFormat(1, 16, bits, static_cast<unsigned short>(bits - 1), s.is_signed));
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetByteValue(reinterpret_cast<const char*>(s.pixels.data()),
                      static_cast<std::uint32_t>(2 * s.pixels.size()));
  image.SetDataElement(pixels);
  image.SetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);

  gdcm::Anonymizer edit;  // GDCM's class that sets attributes by tag and text
  edit.SetFile(writer.GetFile());
  const std::string media = s.modality == "MR" ? "1.2.840.10008.5.1.4.1.1.4" : "1.2.840.10008.5.1.4.1.1.2";
  const auto three = [](const Eigen::Vector3d& v) {
    return fmt::format("{:.6f}\\{:.6f}\\{:.6f}", v[0], v[1], v[2]);
  };
  const auto set = [&](unsigned group, unsigned element, const std::string& value) {
    edit.Replace(gdcm::Tag(static_cast<std::uint16_t>(group), static_cast<std::uint16_t>(element)),
                 value.c_str());
  };
  set(0x0008, 0x0016, media), set(0x0008, 0x0018, s.instance), set(0x0020, 0x000e, s.series);
  set(0x0008, 0x0008, s.image_type), set(0x0008, 0x0060, s.modality), set(0x0008, 0x103e, s.description);
  set(0x0020, 0x0012, s.acquisition), set(0x0020, 0x0032, three(s.position));
  set(0x0020, 0x0037, three(s.along_row) + "\\" + three(s.along_column));
  set(0x0028, 0x0030, fmt::format("{}\\{}", s.row_spacing, s.column_spacing));
  writer.SetFileName(path.c_str());
  if (!writer.Write()) throw std::runtime_error("GDCM cannot write " + path);

  // ImageWriter sets position, spacing and scaling from its Image by its own rules, so they are set again
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) throw std::runtime_error("GDCM cannot read " + path);
  edit.SetFile(reader.GetFile());
  set(0x0020, 0x0032, three(s.position)),
      set(0x0020, 0x0037, three(s.along_row) + "\\" + three(s.along_column));
  set(0x0028, 0x0030, fmt::format("{}\\{}", s.row_spacing, s.column_spacing));
  if (!s.position_text.empty()) set(0x0020, 0x0032, s.position_text);
  if (!s.pixel_spacing_text.empty()) set(0x0028, 0x0030, s.pixel_spacing_text);
  if (!s.thickness.empty()) set(0x0018, 0x0050, s.thickness);
  if (!s.spacing_between.empty()) set(0x0018, 0x0088, s.spacing_between);
  if (!s.location.empty()) set(0x0020, 0x1041, s.location);
  if (!s.diameter.empty()) set(0x0018, 0x1100, s.diameter);
  set(0x0028, 0x1053, s.slope_text.empty() ? fmt::format("{}", s.slope) : s.slope_text);
  set(0x0028, 0x1052, s.intercept_text.empty() ? fmt::format("{}", s.intercept) : s.intercept_text);
  if (!s.scaled)
    for (const std::uint16_t element : {0x1052, 0x1053}) edit.Remove(gdcm::Tag(0x0028, element));
  set(0x0028, 0x1054, "HU");
  if (!s.patient_position.empty()) set(0x0018, 0x5100, s.patient_position);
  if (!s.patient_sex.empty()) set(0x0010, 0x0040, s.patient_sex);
  if (!s.patient_age.empty()) set(0x0010, 0x1010, s.patient_age);
  if (s.frames > 1) set(0x0028, 0x0008, std::to_string(s.frames));
  if (s.padding) {
    gdcm::DataElement padding(gdcm::Tag(0x0028, 0x0120), 0, s.is_signed ? gdcm::VR::SS : gdcm::VR::US);
    padding.SetByteValue(reinterpret_cast<const char*>(&*s.padding), 2);
    reader.GetFile().GetDataSet().Replace(padding);
  }
  gdcm::Writer again;
  again.SetFile(reader.GetFile());
  again.SetFileName(path.c_str());
  if (!again.Write()) throw std::runtime_error("GDCM cannot write " + path);
}

}  // namespace borelli
