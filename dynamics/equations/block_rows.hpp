// Sparse rows in blocks of columns, with a mask of the blocks that may have entries.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

class BlockRows {
 public:
  static constexpr int width = 8;  ///< columns per block

  BlockRows(Eigen::Index rows, Eigen::Index columns)
      : blocks_((columns + width - 1) / width),
        words_((blocks_ + 63) / 64),
        numbers_(RowsOf<double>::Zero(rows, blocks_ * width)),
        masks_(rows * words_) {}

  Eigen::Index rows() const { return numbers_.rows(); }
  Eigen::Index padded_columns() const { return numbers_.cols(); }

  /// The numbers of a row, padded with zeros to whole blocks.
  double* row(int r) { return numbers_.row(r).data(); }
  const double* row(int r) const { return numbers_.row(r).data(); }

  /// Updates the mask of row r; call it after writing to row(r).
  void find_blocks(int r) {
    std::uint64_t* mask = masks_.data() + r * words_;
    std::fill(mask, mask + words_, 0);
    for (Eigen::Index b = 0; b < blocks_; ++b)
      if (!(block(r, b) == 0).all()) mask[b / 64] |= std::uint64_t(1) << (b % 64);
  }

  void clear(int r) {
    numbers_.row(r).setZero();
    std::fill_n(masks_.data() + r * words_, words_, 0);
  }

  double squared_norm(int r) const {
    double sum = 0;
    visit(masks_.data() + r * words_, nullptr, [&](Eigen::Index b) { sum += block(r, b).square().sum(); });
    return sum;
  }

  /// Whether row r here and row o of `other` share a block. Both must have the same number of columns.
  bool shares(int r, const BlockRows& other, int o) const {
    for (Eigen::Index w = 0; w < words_; ++w)
      if (masks_[r * words_ + w] & other.masks_[o * words_ + w]) return true;
    return false;
  }

  /// Row r here . row o of `other`. Both must have the same number of columns.
  double dot(int r, const BlockRows& other, int o) const {
    double sum = 0;
    visit(masks_.data() + r * words_, other.masks_.data() + o * words_,
          [&](Eigen::Index b) { sum += (block(r, b) * other.block(o, b)).sum(); });
    return sum;
  }

  /// row r += factor times row o of the other.
  void add(int r, double factor, const BlockRows& other, int o) {
    const std::uint64_t* mask = other.masks_.data() + o * words_;
    visit(mask, nullptr, [&](Eigen::Index b) { block(r, b) += factor * other.block(o, b); });
    for (Eigen::Index w = 0; w < words_; ++w) masks_[r * words_ + w] |= mask[w];
  }

  /// x (columns) += factor times row r.
  void add_to(double* x, double factor, int r) const {
    visit(masks_.data() + r * words_, nullptr, [&](Eigen::Index b) {
      Eigen::Map<Eigen::Array<double, width, 1>>(x + b * width) += factor * block(r, b);
    });
  }

 private:
  Eigen::Map<Eigen::Array<double, width, 1>> block(int r, Eigen::Index b) {
    return Eigen::Map<Eigen::Array<double, width, 1>>(numbers_.row(r).data() + b * width);
  }
  Eigen::Map<const Eigen::Array<double, width, 1>> block(int r, Eigen::Index b) const {
    return Eigen::Map<const Eigen::Array<double, width, 1>>(numbers_.row(r).data() + b * width);
  }

  /// Visits the blocks of a mask, or those common to two masks (the second may be null).
  template <class Visit>
  void visit(const std::uint64_t* mask, const std::uint64_t* other, Visit&& each) const {
    for (Eigen::Index w = 0; w < words_; ++w)
      for (std::uint64_t left = other ? mask[w] & other[w] : mask[w]; left; left &= left - 1)
        each(w * 64 + std::countr_zero(left));
  }

  Eigen::Index blocks_, words_;
  RowsOf<double> numbers_;
  std::vector<std::uint64_t> masks_;  ///< words_ per row
};

}  // namespace borelli
