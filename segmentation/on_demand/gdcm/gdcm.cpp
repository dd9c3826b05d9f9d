#include "segmentation/on_demand/gdcm.hpp"

#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>
#include <gdcmWriter.h>

#include <exception>
#include <string_view>

#include "process/on_demand.hpp"

namespace borelli {
namespace {

// GDCM's file reader aborts on damaged headers, so GDCM gets only the pixels.
Result<void> unpack(const DicomSlice& slice, std::span<const std::byte> stream, std::span<std::byte> to,
                    DicomPixels& p) try {
  gdcm::Trace::DebugOff(), gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff();  // no printing by the library
  const auto syntax = gdcm::TransferSyntax::GetTSType(p.packing.c_str());
  if (syntax == gdcm::TransferSyntax::TS_END)
    return failure(slice.path, "has pixels in an unsupported compression (" + p.packing + ")");

  gdcm::Fragment fragment;
  fragment.SetByteValue(reinterpret_cast<const char*>(stream.data()),
                        static_cast<std::uint32_t>(stream.size()));
  gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
  fragments->AddFragment(fragment);
  gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
  element.SetVR(gdcm::VR::OB);
  element.SetValue(*fragments);

  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(slice.columns)),
      image.SetDimension(1, static_cast<unsigned>(slice.rows));
  const auto bits = [](int n) { return static_cast<unsigned short>(n); };
  image.SetPixelFormat(
      gdcm::PixelFormat(1, bits(p.bits_allocated), bits(p.bits_stored), bits(p.high_bit), p.is_signed));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax(syntax));
  image.SetDataElement(element);
  if (image.GetBufferLength() != to.size() || !image.GetBuffer(reinterpret_cast<char*>(to.data())))
    return failure(slice.path,
                   "has pixels that cannot be decompressed: cut off or damaged (" + slice.packing + ")");
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  if (format.GetBitsAllocated() != p.bits_allocated)
    return failure(slice.path, fmt::format("decompresses to pixels of {} bits, and its header promises {}",
                                           format.GetBitsAllocated(), p.bits_allocated));
  p.bits_stored = format.GetBitsStored(), p.high_bit = format.GetHighBit();
  p.is_signed = format.GetPixelRepresentation() == 1;
  return {};
} catch (const std::exception&) {  // GDCM's text does not help a user
  return failure(slice.path, "has pixels that cannot be decompressed: damaged (" + slice.packing + ")");
}

gdcm::DataSet in_gdcm(const DicomDataSet& set) {
  gdcm::DataSet out;
  for (const DicomElement& own : set) {
    gdcm::DataElement element(
        gdcm::Tag(static_cast<std::uint16_t>(own.tag >> 16), static_cast<std::uint16_t>(own.tag)));
    element.SetVR(gdcm::VR::GetVRTypeFromFile(own.vr));
    if (std::string_view(own.vr) == "SQ") {
      gdcm::SmartPointer<gdcm::SequenceOfItems> items = new gdcm::SequenceOfItems;
      items->SetLengthToUndefined();
      for (const DicomDataSet& nested : own.items) {
        gdcm::Item item;
        item.SetVLToUndefined();
        item.SetNestedDataSet(in_gdcm(nested));
        items->AddItem(item);
      }
      element.SetValue(*items);
      element.SetVLToUndefined();
    } else if (!own.value.empty()) {
      const std::string_view vr = own.vr;
      std::string value = own.value;
      if (value.size() % 2) value += vr == "UI" || vr == "OB" ? '\0' : ' ';
      element.SetByteValue(value.data(), static_cast<std::uint32_t>(value.size()));
    }
    out.Insert(element);
  }
  return out;
}

bool write(std::ostream& stream, const DicomDataSet& set) try {
  gdcm::Trace::DebugOff(), gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff();
  gdcm::Writer writer;
  gdcm::File& file = writer.GetFile();
  file.SetDataSet(in_gdcm(set));
  file.GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
  writer.SetStream(stream);
  return writer.Write() && stream.flush();
} catch (const std::exception&) {
  return false;
}

}  // namespace
}  // namespace borelli

BORELLI_ON_DEMAND(borelli::GdcmFunctions){.unpack = borelli::unpack, .write = borelli::write};
