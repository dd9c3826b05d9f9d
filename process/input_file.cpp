#include "process/input_file.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

#include "process/memory.hpp"

namespace borelli {

namespace {

tl::unexpected<Error> too_large(const std::filesystem::path& path, std::uint64_t most) {
  return failure(path.string(), "exceeds " + std::to_string(most >> 20) + " MiB, the limit for a text file");
}

}  // namespace

Result<void> check_input_file(const std::filesystem::path& path, std::uint64_t most) {
  std::error_code trouble;
  switch (std::filesystem::status(path, trouble).type()) {
    case std::filesystem::file_type::regular:
      break;
    case std::filesystem::file_type::not_found:
      return bad_use(path.string(), "no such file");
    case std::filesystem::file_type::directory:
      return bad_use(path.string(), "is a folder, expected a file");
    default:
      return bad_use(path.string(), trouble ? "cannot be opened: " + trouble.message()
                                            : "is not a regular file but a pipe or a device");
  }
  const std::uint64_t size = std::filesystem::file_size(path, trouble);
  if (!trouble && size > most) return too_large(path, most);
  return {};
}

Result<std::string> read_input_file(const std::filesystem::path& path, std::uint64_t most) {
  if (auto fine = check_input_file(path, most); !fine) return tl::unexpected(fine.error());
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) return bad_use(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
  std::error_code trouble;
  const std::uint64_t size = std::filesystem::file_size(path, trouble);
  if (trouble) return failure(path.string(), "cannot be read: " + trouble.message());
  if (auto fits = admit_memory(path.string(), "its content", static_cast<double>(size)); !fits)
    return tl::unexpected(fits.error());
  std::string bytes;
  bytes.reserve(size);
  std::array<char, 65536> block;  // file_size is 0 in /proc, and a file may grow while it is read
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), file.get())) {
    if (got > most - bytes.size()) return too_large(path, most);
    bytes.append(block.data(), got);
  }
  if (std::ferror(file.get()))
    return failure(path.string(), std::string("cannot be read: ") + std::strerror(errno));
  return bytes;
}

}  // namespace borelli
