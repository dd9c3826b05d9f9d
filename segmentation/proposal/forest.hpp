// Extremely randomised trees (Geurts, Ernst & Wehenkel 2006, Machine Learning 63:3): reads a model file, and
// computes class probabilities from a row of features. segmentation/training trains them.
//
// The file: lines of text, each a key and its words, then bytes compressed by zlib's deflate.
//   borelli-forest 1
//   features NAME ...         in the order of a row
//   classes NAME ...
//   deviation NAME VALUE      any number of them: standard deviations measured in training
//   trees N
//   bytes PACKED UNPACKED CRC32     CRC-32 of the unpacked bytes, in hexadecimal digits
// Unpacked: each tree in preorder. A branch is the feature's index (1 byte) and the threshold (2 bytes,
// little-endian, signed). The left subtree, for values up to the threshold, follows, then the right one. A
// leaf is the byte 255 and the probability of each class in 255ths, one byte each, with a sum of 255.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

class Forest {
 public:
  std::vector<std::string> features, classes;
  std::map<std::string, double, std::less<>> deviations;

  std::size_t trees() const { return roots_.size(); }
  std::size_t nodes() const { return nodes_.size(); }
  /// Probability of each class in units of 1 / whole(): the sum over the trees' leaves. Sizes: #features,
  /// #classes.
  void add_up(std::span<const std::int16_t> row, std::span<std::uint32_t> sums) const;
  std::uint32_t whole() const { return 255 * static_cast<std::uint32_t>(trees()); }

 private:
  friend Result<Forest> parse_forest(std::string_view, const std::string&);
  struct Node {
    std::int16_t threshold = 0;
    std::uint8_t feature = 0;  // leaf_mark: a leaf
    std::uint32_t next =
        0;  // branch: index of the right subtree (the left one follows); leaf: offset in leaves_
  };
  static constexpr std::uint8_t leaf_mark = 255;

  std::vector<std::uint32_t> roots_;
  std::vector<Node> nodes_;
  std::vector<std::uint8_t> leaves_;
};

/// Parses a model file's bytes; `where` names them in errors. Errors: another format or version, a damaged
/// file.
Result<Forest> parse_forest(std::string_view bytes, const std::string& where);

/// Reads a model file. Errors: as above; a file that cannot be read.
Result<Forest> read_forest(const std::string& path);

}  // namespace borelli
