#include "pipeline/files/hdf5_file.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include "pipeline/files/digest.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/on_demand/hdf5.hpp"
#include "process/child.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"
#include "process/on_demand.hpp"

namespace borelli {
namespace {

// Searches HDF5's signature where the format allows it: at byte 0, 512, 1024, 2048, ...
bool has_signature(const std::filesystem::path& path) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  std::ifstream file(path, std::ios::binary);
  std::string found(signature.size(), '\0');
  for (std::streamoff at = 0; file; at = at == 0 ? 512 : 2 * at)
    if (file.seekg(at).read(found.data(), static_cast<std::streamsize>(found.size())) && found == signature)
      return true;
  return false;
}

constexpr std::string_view before_digest = "\nborelli sha256 ";
constexpr std::size_t seal_size = before_digest.size() + 64 + 1;

// The last bytes of a file that close() writes.
std::string seal(const std::string& digest) { return std::string(before_digest) + digest + '\n'; }

// Whether the file ends with the digest of its other bytes. Errors: a wrong or truncated digest.
Result<bool> bears_digest(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg(), rest = size - static_cast<std::streamoff>(seal_size);
  if (!file || rest < 0) return false;
  std::string end(seal_size, '\0');
  file.seekg(rest).read(end.data(), static_cast<std::streamsize>(end.size()));
  if (!file) return false;
  if (const auto at = end.find(before_digest); at != 0 || end.back() != '\n') {
    if (at == std::string::npos) return false;
    return failure(path.string(), "is damaged or cut short: its checksum is missing at the end");
  }
  const auto digest = digest_of_start(path, static_cast<std::uint64_t>(rest));
  if (!digest) return tl::unexpected(digest.error());
  if (end == seal(*digest)) return true;
  return failure(path.string(), "is damaged: its bytes differ from those written (SHA-256)");
}

double size_of_file(const std::filesystem::path& path) {
  std::error_code problem;
  return static_cast<double>(std::filesystem::file_size(path, problem));
}

// Limits on reading a file without a digest.
ChildLimits limits_for(const std::filesystem::path& path) {
  const double size = size_of_file(path);
  ChildLimits limits;
  limits.processor_seconds = 0.2 + size / 20e6;
  limits.seconds = 5 + size / 5e6;
  limits.bytes = std::min<std::uint64_t>(
      memory_limit(), (std::uint64_t{256} << 20) + static_cast<std::uint64_t>(1000 * size));
  return limits;
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path) : path_(path.string()) {
  const auto hdf5 = on_demand<Hdf5Functions>();
  if (!hdf5) {
    check(false, hdf5.error().message());
    return;
  }
  functions_ = *hdf5;
  file_ = functions_->create(path_);
  check(file_ >= 0, "HDF5 cannot create a file in memory");
}

Hdf5Writer::~Hdf5Writer() {
  if (file_ >= 0) functions_->close(file_);
}

void Hdf5Writer::check(bool fine, const std::string& what) {
  if (!fine && problem_.empty()) problem_ = what;
}

void Hdf5Writer::numbers(const std::string& name, const std::vector<std::size_t>& shape, const double* values,
                         const std::string& units) {
  if (!problem_.empty()) return;
  check(functions_->put_numbers(file_, name, shape, values), "cannot write " + name);
  if (!units.empty()) attribute(name, "units", units);
}

void Hdf5Writer::texts(const std::string& name, const std::vector<std::string>& values) {
  if (!problem_.empty()) return;
  check(functions_->put_texts(file_, name, values), "cannot write " + name);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, const std::string& text) {
  if (!problem_.empty()) return;
  check(functions_->put_text_attribute(file_, object, name, text),
        "cannot write the attribute " + name + " of " + object);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, double number) {
  if (!problem_.empty()) return;
  check(functions_->put_number_attribute(file_, object, name, number),
        "cannot write the attribute " + name + " of " + object);
}

void Hdf5Writer::group(const std::string& name) {
  if (!problem_.empty()) return;
  check(functions_->put_group(file_, name), "cannot create the group " + name);
}

Result<void> Hdf5Writer::close() {
  std::string image;
  if (file_ >= 0) {
    if (problem_.empty()) problem_ = functions_->image(file_, image, seal_size);
    check(functions_->close(file_), "HDF5 cannot close the file");
    file_ = -1;
  }
  if (!problem_.empty()) return failure(path_, problem_);
  image += seal(digest_of_bytes(image));
  return write_bytes(path_, image);
}

Result<void> Hdf5Reader::read(const std::filesystem::path& path,
                              const std::function<Result<void>(const Hdf5Reader&)>& take) {
  const auto attempt = [&]() -> Result<void> {
    const auto file = open(path);
    if (!file) return tl::unexpected(file.error());
    return take(*file);
  };
  std::error_code problem;
  if (std::filesystem::is_regular_file(path, problem) && has_signature(path)) {
    const auto known = bears_digest(path);
    if (!known) return tl::unexpected(known.error());
    if (const auto hdf5 = on_demand<Hdf5Functions>(); !hdf5) return tl::unexpected(hdf5.error());
    if (!*known)
      if (auto fine = in_child(path.string(), "is damaged: reading it as HDF5", limits_for(path), attempt);
          !fine)
        return fine;
  }
  return attempt();
}

Result<Hdf5Reader> Hdf5Reader::open(const std::filesystem::path& path) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  if (!has_signature(path)) return bad_use(path.string(), "is not an HDF5 file");
  const auto hdf5 = on_demand<Hdf5Functions>();
  if (!hdf5) return tl::unexpected(hdf5.error());
  const std::int64_t file = (*hdf5)->open(path.string());
  if (file < 0)
    return failure(path.string(), "is an HDF5 file, but is damaged or cut short and cannot be opened");
  return Hdf5Reader(path.string(), file, **hdf5);
}

Hdf5Reader::~Hdf5Reader() {
  if (file_ >= 0) functions_->close(file_);
}

Hdf5Reader::Hdf5Reader(Hdf5Reader&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)), functions_(other.functions_) {}

tl::unexpected<Error> Hdf5Reader::damaged(const std::string& name, const std::string& problem) const {
  return failure(path_, name + " " + problem);
}

bool Hdf5Reader::holds(const std::string& name) const { return functions_->holds(file_, name); }

Result<Hdf5Array> Hdf5Reader::numbers(const std::string& name) const {
  if (!holds(name)) return damaged(name, "is missing");
  Result<void> fits;
  const auto admit = [&](double bytes) {
    fits = admit_memory(path_, name, bytes);
    return fits.has_value();
  };
  Hdf5Array out;
  const std::string problem = functions_->numbers(file_, name, size_of_file(path_), admit, out);
  if (!fits) return tl::unexpected(fits.error());
  if (!problem.empty()) return damaged(name, problem);
  return out;
}

Result<std::vector<std::string>> Hdf5Reader::texts(const std::string& name) const {
  if (!holds(name)) return damaged(name, "is missing");
  std::vector<std::string> out;
  const std::string problem = functions_->texts(file_, name, size_of_file(path_), out);
  if (!problem.empty()) return damaged(name, problem);
  return out;
}

Result<std::string> Hdf5Reader::text_attribute(const std::string& object, const std::string& name) const {
  std::string out;
  const std::string problem = functions_->text_attribute(file_, object, name, out);
  if (!problem.empty()) return damaged("attribute " + name + " of " + object, problem);
  return out;
}

Result<double> Hdf5Reader::number_attribute(const std::string& object, const std::string& name) const {
  double out = 0;
  const std::string problem = functions_->number_attribute(file_, object, name, out);
  if (!problem.empty()) return damaged("attribute " + name + " of " + object, problem);
  return out;
}

}  // namespace borelli
