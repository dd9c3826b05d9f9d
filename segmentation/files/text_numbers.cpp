#include "segmentation/files/text_numbers.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cstring>

#include "error/printable.hpp"
#include "segmentation/files/image_file.hpp"

namespace borelli {
namespace {

constexpr std::size_t longest_word = 400;  // the digits of the smallest double

bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

}  // namespace

TextNumbers::TextNumbers(std::string path, ByteSource& source, Scalar scalar)
    : path_(std::move(path)), source_(source), scalar_(scalar), block_(ByteSource::block) {}

// The next word without the commas around it; empty at the end of the text. Commas within it stay, as it may
// be a number with a decimal comma.
Result<std::string_view> TextNumbers::next_word() {
  std::size_t length = 0;
  for (;;) {
    while (length == 0 && at_ < end_ && (is_blank(block_[at_]) || block_[at_] == ',')) ++at_;
    while (at_ + length < end_ && !is_blank(block_[at_ + length])) ++length;
    if (at_ + length < end_) break;
    // the word may continue in the next block
    std::memmove(block_.data(), block_.data() + at_, length);
    at_ = 0, end_ = length;
    if (length > longest_word) break;
    const auto got = source_.read(std::as_writable_bytes(std::span(block_).subspan(length)));
    if (!got) return tl::unexpected(got.error());
    if (*got == 0) break;
    end_ += *got;
  }
  std::string_view word(block_.data() + at_, length);
  at_ += length;
  while (word.ends_with(',')) word.remove_suffix(1);
  return word;
}

Result<void> TextNumbers::finish() {
  const auto word = next_word();
  if (!word) return tl::unexpected(word.error());
  if (word->empty()) return {};
  return failure(path_, "contains more numbers than the voxels that its header states");
}

Result<std::size_t> TextNumbers::read(std::span<std::byte> target) {
  return with_scalar(scalar_, [&]<class T>(T) -> Result<std::size_t> {
    std::size_t filled = 0;
    for (; filled + sizeof(T) <= target.size(); filled += sizeof(T)) {
      const auto word = next_word();
      if (!word) return tl::unexpected(word.error());
      if (word->empty()) break;
      const char* const first = word->data() + (word->front() == '+');
      const char* const last = word->data() + word->size();
      T value{};
      const auto [rest, trouble] = std::from_chars(first, last, value);
      if (trouble != std::errc() || rest != last) {
        return failure(path_, fmt::format("has '{}' among its voxels; expected numbers of type {}",
                                          printable(*word), scalar_name(scalar_)));
      }
      std::memcpy(target.data() + filled, &value, sizeof value);
    }
    return filled;
  });
}

}  // namespace borelli
