// Checkpoints: saves what a run carries from step to step as bytes. A run restored from them continues as if
// it had not been interrupted. Each part of a run lists its members once, in `keep(Keeper&)`, for saving and
// restoring.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// FNV-1a, 64 bits. A change of one byte always changes it; other changes almost always.
inline std::uint64_t checksum_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

class Keeper {
 public:
  /// Saves.
  Keeper() = default;
  /// Restores what another Keeper saved, in the same order. A list or matrix that already has entries must
  /// have the same size in `bytes`, since the scene determines it.
  explicit Keeper(std::string bytes) : filling_(true), bytes_(std::move(bytes)) {}

  template <class... Things>
  void operator()(Things&... things) {
    (keep(things), ...);
  }

  /// A number from `lowest` to `highest`. A restored number outside this range marks the data as damaged.
  template <class T>
  void within(T& number, T lowest, T highest) {
    T there = number;
    keep(there);
    if (!(there >= lowest && there <= highest)) damaged_ = true;
    if (!damaged_) number = there;
  }
  /// A list that grows during the run: the restored one may have any size.
  template <class T>
  void growing(std::vector<T>& list) {
    if (filling_) list.clear();
    keep(list);
  }
  /// The number of entries that follow, each of at least `least` bytes. If fewer bytes remain on restoring,
  /// the data is damaged.
  void count(std::size_t& number, std::size_t least) {
    keep(number);
    if (filling_ && (damaged_ || number > (bytes_.size() - at_) / least)) damaged_ = true, number = 0;
  }

  const std::string& bytes() const { return bytes_; }
  /// After restoring: whether all bytes were used, and none were missing or damaged.
  bool whole() const { return !damaged_ && at_ == bytes_.size(); }

 private:
  template <class T>
  void keep(T& thing) {
    if constexpr (requires { thing.keep(*this); })
      thing.keep(*this);
    else {
      static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
      raw(&thing, sizeof thing);
    }
  }
  void keep(bool& yes) {
    char byte = yes ? 1 : 0;
    within(byte, '\0', '\1');
    yes = byte != 0;
  }
  void keep(Pose& X) { keep(X.R), keep(X.p); }
  void keep(std::string& text) {
    std::size_t count = text.size();
    this->count(count, 1);
    text.resize(count);
    raw(text.data(), count);
  }
  template <class T>
  void keep(std::vector<T>& list) {
    std::size_t count = list.size();
    this->count(count, 1);
    if (!list.empty() && count != list.size()) damaged_ = true;
    if (damaged_) return;
    list.resize(count);
    for (T& entry : list) keep(entry);
  }
  template <class A, class B>
  void keep(std::pair<A, B>& pair) {
    keep(pair.first), keep(pair.second);
  }
  template <class T, int rows, int columns, int options>
  void keep(Eigen::Matrix<T, rows, columns, options>& matrix) {
    Eigen::Index height = matrix.rows(), width = matrix.cols();
    keep(height), keep(width);
    if (damaged_ || height < 0 || width < 0 || (rows >= 0 && height != rows) ||
        (columns >= 0 && width != columns) ||
        (matrix.size() > 0 && (height != matrix.rows() || width != matrix.cols())) ||
        (width > 0 && std::size_t(height) > most_ / std::size_t(width))) {
      damaged_ = true;
      return;
    }
    std::size_t count = std::size_t(height * width);
    if (filling_ && count * sizeof(T) > bytes_.size() - at_) {
      damaged_ = true;
      return;
    }
    if constexpr (rows < 0 || columns < 0) matrix.resize(height, width);
    raw(matrix.data(), count * sizeof(T));
  }

  void raw(void* place, std::size_t size) {
    if (damaged_ || size == 0) return;
    if (!filling_) {
      bytes_.append(static_cast<const char*>(place), size);
    } else if (size > bytes_.size() - at_) {
      damaged_ = true;
    } else {
      std::memcpy(place, bytes_.data() + at_, size);
      at_ += size;
    }
  }

  static constexpr std::size_t most_ = std::size_t(1) << 40;
  bool filling_ = false, damaged_ = false;
  std::string bytes_;
  std::size_t at_ = 0;
};

}  // namespace borelli
