#include "pipeline/files/digest.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <vector>

#include "process/input_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

class Digest {
 public:
  Digest() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string hex() {
    static constexpr char digits[] = "0123456789abcdef";
    std::array<unsigned char, EVP_MAX_MD_SIZE> raw;
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), raw.data(), &size);
    std::string text;
    for (unsigned i = 0; i < size; ++i) text += {digits[raw[i] >> 4], digits[raw[i] & 15]};
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

Result<void> add_file(Digest& digest, const fs::path& path,
                      std::uint64_t count = std::numeric_limits<std::uint64_t>::max()) {
  if (auto fine = check_input_file(path); !fine) return fine;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> buffer(1 << 16);
  while (file && count > 0) {
    file.read(buffer.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(buffer.size(), count)));
    digest.add({buffer.data(), static_cast<std::size_t>(file.gcount())});
    count -= static_cast<std::uint64_t>(file.gcount());
  }
  if (!file && !file.eof()) return failure(path.string(), "cannot be read");
  return {};
}

}  // namespace

std::string digest_of_bytes(std::string_view bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.hex();
}

Result<std::string> digest_of_start(const fs::path& file, std::uint64_t count) {
  Digest digest;
  if (auto added = add_file(digest, file, count); !added) return tl::unexpected(added.error());
  return digest.hex();
}

Result<std::string> digest_of(const fs::path& path) {
  Digest digest;
  std::error_code problem;
  if (!fs::exists(path, problem)) return bad_use(path.string(), "no such file or folder");
  if (!fs::is_directory(path, problem)) {
    if (auto added = add_file(digest, path); !added) return tl::unexpected(added.error());
    return digest.hex();
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path, problem))
    if (entry.is_regular_file(problem)) files.push_back(entry.path());
  std::ranges::sort(files);
  for (const auto& file : files) {
    digest.add(file.lexically_relative(path).string());
    if (auto added = add_file(digest, file); !added) return tl::unexpected(added.error());
  }
  return digest.hex();
}

}  // namespace borelli
