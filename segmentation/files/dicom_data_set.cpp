#include "segmentation/files/dicom_data_set.hpp"

#include <optional>
#include <ostream>
#include <streambuf>

#include "process/on_demand.hpp"
#include "segmentation/files/byte_stream.hpp"
#include "segmentation/on_demand/gdcm.hpp"

namespace borelli {
namespace {

// Passes what GDCM writes to a stream on to a file, and keeps the first error. GDCM sees no error: Debian's
// has assertions, and a failed stream would abort the process.
class SinkBuffer : public std::streambuf {
 public:
  explicit SinkBuffer(ByteSink& sink) : sink_(sink) {}
  std::optional<Error> error;

 protected:
  std::streamsize xsputn(const char* from, std::streamsize count) override {
    if (error) return count;
    if (auto done = sink_.write(std::string_view(from, static_cast<std::size_t>(count))); !done)
      error = done.error();
    return count;
  }
  int_type overflow(int_type c) override {
    const char one = traits_type::to_char_type(c);
    xsputn(&one, 1);
    return c;
  }

 private:
  ByteSink& sink_;
};

}  // namespace

Result<void> write_dicom(const std::string& path, const DicomDataSet& set) {
  const auto gdcm = on_demand<GdcmFunctions>();
  if (!gdcm) return tl::unexpected(gdcm.error());
  auto sink = ByteSink::create(path, ByteSink::Packing::plain);
  if (!sink) return tl::unexpected(sink.error());
  SinkBuffer buffer(*sink);
  std::ostream stream(&buffer);
  const bool written = (*gdcm)->write(stream, set);
  if (buffer.error) return tl::unexpected(*buffer.error);
  if (!written)
    return failure(path, "was not written: the library GDCM refused its contents; please report this");
  return sink->close();
}

}  // namespace borelli
