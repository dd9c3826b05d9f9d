#include "tests/suite/finer_slices.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "segmentation/grid/squared_distances.hpp"
#include "threads/slabs.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector2f;

// A plane of pixels; values between them are linear, values beyond its edge those of the edge.
struct Image {
  std::int64_t width = 0, height = 0;
  std::vector<float> value;

  Image() = default;
  Image(std::int64_t w, std::int64_t h) : width(w), height(h), value(static_cast<std::size_t>(w * h)) {}
  float& at(std::int64_t i, std::int64_t j) { return value[static_cast<std::size_t>(j * width + i)]; }
  float at(std::int64_t i, std::int64_t j) const { return value[static_cast<std::size_t>(j * width + i)]; }
  float near(std::int64_t i, std::int64_t j) const {
    return at(std::clamp<std::int64_t>(i, 0, width - 1), std::clamp<std::int64_t>(j, 0, height - 1));
  }
  float operator()(Vector2f p) const {
    p = p.cwiseMax(0).cwiseMin(Vector2f(float(width - 1), float(height - 1)));
    const auto i = static_cast<std::int64_t>(p.x()), j = static_cast<std::int64_t>(p.y());
    const float a = p.x() - float(i), b = p.y() - float(j);
    const std::int64_t next = std::min(i + 1, width - 1), above = std::min(j + 1, height - 1);
    return (1 - b) * ((1 - a) * at(i, j) + a * at(next, j)) +
           b * ((1 - a) * at(i, above) + a * at(next, above));
  }
};

// Convolves with the binomial (1 4 6 4 1) / 16 along both axes: a Gaussian of one pixel's standard deviation.
Image smoothed(const Image& in) {
  Image along(in.width, in.height), out(in.width, in.height);
  const auto five = [](float a, float b, float c, float d, float e) {
    return (a + e + 4 * (b + d) + 6 * c) / 16;
  };
  for (std::int64_t j = 0; j < in.height; ++j)
    for (std::int64_t i = 0; i < in.width; ++i)
      along.at(i, j) =
          five(in.near(i - 2, j), in.near(i - 1, j), in.at(i, j), in.near(i + 1, j), in.near(i + 2, j));
  for (std::int64_t j = 0; j < in.height; ++j)
    for (std::int64_t i = 0; i < in.width; ++i)
      out.at(i, j) = five(along.near(i, j - 2), along.near(i, j - 1), along.at(i, j), along.near(i, j + 1),
                          along.near(i, j + 2));
  return out;
}

// every second pixel of the smoothed image
Image halved(const Image& in) {
  const Image smooth = smoothed(in);
  Image out((in.width + 1) / 2, (in.height + 1) / 2);
  for (std::int64_t j = 0; j < out.height; ++j)
    for (std::int64_t i = 0; i < out.width; ++i) out.at(i, j) = smooth.at(2 * i, 2 * j);
  return out;
}

// Displacements from one slice to the next, pixels: from(x - u/2) resembles to(x + u/2).
struct Field {
  Image x, y;

  Vector2f operator()(const Vector2f& p) const { return {x(p), y(p)}; }
  Vector2f at(std::int64_t i, std::int64_t j) const { return {x.at(i, j), y.at(i, j)}; }
};

// One iteration of the demons: a Gauss-Newton step at each pixel, then smoothing.
void improve(Field& field, const Image& from, const Image& to) {
  Image ahead(from.width, from.height), behind = ahead;
  for (std::int64_t j = 0; j < from.height; ++j)
    for (std::int64_t i = 0; i < from.width; ++i) {
      const Vector2f p{float(i), float(j)}, half = field.at(i, j) / 2;
      behind.at(i, j) = from(p - half), ahead.at(i, j) = to(p + half);
    }
  for (std::int64_t j = 0; j < from.height; ++j)
    for (std::int64_t i = 0; i < from.width; ++i) {
      const auto slope = [&](const Image& image) -> Vector2f {
        return Vector2f(image.near(i + 1, j) - image.near(i - 1, j),
                        image.near(i, j + 1) - image.near(i, j - 1)) /
               2;
      };
      const Vector2f gradient = (slope(behind) + slope(ahead)) / 2;
      const float difference = behind.at(i, j) - ahead.at(i, j);
      // the second term bounds a step to half a pixel
      const float length = gradient.squaredNorm() + difference * difference;
      if (length < 1e-8F) continue;
      field.x.at(i, j) += difference * gradient.x() / length;
      field.y.at(i, j) += difference * gradient.y() / length;
    }
  for (Image* part : {&field.x, &field.y}) *part = smoothed(*part);
}

// coarse to fine
Field registered(const Image& from, const Image& to, int levels) {
  Field field{Image(from.width, from.height), Image(from.width, from.height)};
  if (levels > 0) {
    const Field coarse = registered(halved(from), halved(to), levels - 1);
    for (std::int64_t j = 0; j < from.height; ++j)
      for (std::int64_t i = 0; i < from.width; ++i) {
        const Vector2f u = 2 * coarse(Vector2f(float(i), float(j)) / 2);
        field.x.at(i, j) = u.x(), field.y.at(i, j) = u.y();
      }
  }
  constexpr int iterations = 20;
  for (int n = 0; n < iterations; ++n) improve(field, from, to);
  return field;
}

// A slice, its grey values, and each label's signed distance from its border, pixels, positive inside.
struct Slice {
  Volume<std::uint8_t> label;
  Image grey;
  std::map<std::uint8_t, Image> depth;
};

Image depth_of(const Volume<std::uint8_t>& label, std::uint8_t wanted) {
  Volume<std::uint8_t> mask = label;
  for (std::uint8_t& voxel : mask.voxels) voxel = voxel == wanted;
  constexpr std::uint16_t cap = 60 * 60;  // pixels: no shape moves further between two slices
  const auto outside = squared_distances<std::uint16_t>(mask, cap, {.threads = 1});
  const auto inside = squared_distances<std::uint16_t>(mask, cap, {.to_unset = true, .threads = 1});
  Image out(label.grid.size[0], label.grid.size[1]);
  for (std::size_t n = 0; n < out.value.size(); ++n)
    out.value[n] = mask.voxels[n] ? std::sqrt(float(inside.voxels[n])) - 0.5F
                                  : 0.5F - std::sqrt(float(outside.voxels[n]));
  return out;
}

Slice slice_of(const Volume<std::int16_t>& labels, const std::array<float, 256>& grey, std::int64_t k) {
  Grid grid = labels.grid;
  grid.size[2] = 1;
  Slice out{{grid, std::vector<std::uint8_t>(grid.count())}, Image(grid.size[0], grid.size[1]), {}};
  const std::size_t first = labels.grid.offset(0, 0, k);
  for (std::size_t n = 0; n < out.label.voxels.size(); ++n) {
    const auto label = static_cast<std::uint8_t>(labels.voxels[first + n]);
    out.label.voxels[n] = label;
    out.grey.value[n] = grey[label];
    out.depth[label];
  }
  for (auto& [label, depth] : out.depth) depth = depth_of(out.label, label);
  out.grey = smoothed(out.grey);
  return out;
}

class Between {
 public:
  Between(const Slice& below, const Slice& above, float absent)
      : below_(below), above_(above), absent_(absent), field_(registered(below.grey, above.grey, 3)) {
    for (const auto& side : {&below, &above})
      for (const auto& [label, depth] : side->depth) labels_.push_back(label);
    std::sort(labels_.begin(), labels_.end());
    labels_.erase(std::unique(labels_.begin(), labels_.end()), labels_.end());
  }

  // `share`: 0 on the slice below, 1 on the slice above
  std::uint8_t label(std::int64_t i, std::int64_t j, float share) const {
    const Vector2f p{float(i), float(j)}, u = field_.at(i, j);
    const Vector2f low = p - share * u, high = p + (1 - share) * u;
    const std::uint8_t a = nearest(below_, low), b = nearest(above_, high);
    if (a == b) return a;
    std::uint8_t best = share < 0.5F ? a : b;
    float most = depth(best, low, high, share);
    for (const std::uint8_t other : labels_)
      if (const float d = depth(other, low, high, share); d > most) most = d, best = other;
    return best;
  }

 private:
  static std::uint8_t nearest(const Slice& slice, const Vector2f& p) {
    const Grid& g = slice.label.grid;
    return slice.label.at(std::clamp<std::int64_t>(std::llround(p.x()), 0, g.size[0] - 1),
                          std::clamp<std::int64_t>(std::llround(p.y()), 0, g.size[1] - 1), 0);
  }
  float depth(std::uint8_t label, const Vector2f& low, const Vector2f& high, float share) const {
    const auto in = [&](const Slice& slice, const Vector2f& p) {
      const auto found = slice.depth.find(label);
      return found == slice.depth.end() ? -absent_ : found->second(p);
    };
    return (1 - share) * in(below_, low) + share * in(above_, high);
  }

  const Slice &below_, &above_;
  float absent_;  // depth of a label that a slice lacks: it ends within one slice
  Field field_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

Volume<std::int16_t> finer_slices(const Volume<std::int16_t>& labels, const std::array<float, 256>& grey,
                                  int factor, int threads) {
  const Grid& from = labels.grid;
  Volume<std::int16_t> out{from, {}};
  out.grid.size[2] *= factor;
  out.grid.axes.col(2) /= factor;
  out.grid.origin -= out.grid.axes.col(2) * (factor - 1) / 2.0;
  out.voxels.resize(out.grid.count());
  const float absent = float(from.axes.col(2).norm() / from.axes.col(0).norm());
  // the fine slices between the middles of the slices k and k + 1; with those before the first and after the last
  in_turns(from.size[2] + 1, threads, [&](std::int64_t first, std::int64_t last) {
    const auto clamped = [&](std::int64_t k) { return std::clamp<std::int64_t>(k, 0, from.size[2] - 1); };
    Slice above = slice_of(labels, grey, clamped(first - 1));
    for (std::int64_t k = first - 1; k + 1 < last; ++k) {
      const Slice below = std::exchange(above, slice_of(labels, grey, clamped(k + 1)));
      const Between between(below, above, absent);
      for (std::int64_t m = 0; m < factor; ++m) {
        // the middle of fine slice n lies (n + 1/2) / factor - 1/2 thick slices above the first one's
        const std::int64_t n = k * factor + factor / 2 + m;
        const double share = (double(n) + 0.5) / factor - 0.5 - double(k);
        if (n < 0 || n >= out.grid.size[2]) continue;
        for (std::int64_t j = 0; j < from.size[1]; ++j)
          for (std::int64_t i = 0; i < from.size[0]; ++i) out.at(i, j, n) = between.label(i, j, float(share));
      }
    }
  });
  return out;
}

}  // namespace borelli::suite
