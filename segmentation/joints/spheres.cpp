#include "segmentation/joints/spheres.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Range to which CT numbers are clamped for bone edges. Marrow is raised: a joint's gap then still shows
// between two bones, while the marrow's edge does not count.
constexpr int soft_level = 0, bone_level = 500, marrow_level = 250;
// least gradient of a surface voxel, CT numbers per voxel
constexpr double least_slope = 50;

/// Means over three voxels along each axis in turn. Rows wrap around in memory: a row's end is averaged with
/// the next row's start. Works slice by slice, so that intermediate data stay in the cache.
Volume<float> box_blurred(const Volume<float>& in, int threads) {
  const auto& g = in.grid;
  Volume<float> out{g, std::vector<float>(in.voxels.size())};
  const std::int64_t row = g.size[0], slice = g.size[0] * g.size[1], count = std::ssize(in.voxels);
  const float* const from = in.voxels.data();
  const auto mean = [](const float* at, std::int64_t stride) {
    return (at[-stride] + at[0] + at[stride]) / 3;
  };
  in_slabs(g.size[2], threads, [&](std::int64_t first, std::int64_t last) {
    std::vector<float> along_rows(static_cast<std::size_t>(slice + 2 * row));
    std::array<std::vector<float>, 3> within;  // slices
    for (auto& one : within) one.resize(static_cast<std::size_t>(slice));
    for (std::int64_t k = std::max<std::int64_t>(0, first - 1); k < std::min(g.size[2], last + 1); ++k) {
      // the slice, with one row before and one after it
      const std::int64_t begin = k * slice, low = std::max<std::int64_t>(0, begin - row),
                         high = std::min(count, begin + slice + row);
      float* const x = along_rows.data() + row;
      for (std::int64_t o = std::max<std::int64_t>(1, low); o < std::min(count - 1, high); ++o)
        x[o - begin] = mean(from + o, 1);
      if (low == 0) x[-begin] = from[0];
      if (high == count) x[count - 1 - begin] = from[count - 1];
      float* const y = within[static_cast<std::size_t>(k % 3)].data();
      for (std::int64_t o = 0; o < slice; ++o) y[o] = mean(x + o, row);
      if (low == begin) std::copy_n(from, row, y);
      if (high == begin + slice) std::copy_n(from + count - row, row, y + slice - row);
      if ((k == 0 || k + 1 == g.size[2]) && k >= first && k < last)
        std::copy_n(x, slice, out.voxels.data() + begin);
      if (k < first + 1 || k < 2) continue;
      const float* const y_1 = within[static_cast<std::size_t>((k - 1) % 3)].data();
      const float* const y_2 = within[static_cast<std::size_t>((k - 2) % 3)].data();
      float* const to = out.voxels.data() + begin - slice;
      for (std::int64_t o = 0; o < slice; ++o) to[o] = (y_2[o] + y_1[o] + y[o]) / 3;
    }
  });
  return out;
}

// The CT numbers within the range that tells bone, smoothed.
Volume<float> smooth_levels(const Volume<std::int16_t>& hu, const Mask& bone, int threads) {
  Volume<float> level{hu.grid, std::vector<float>(hu.grid.count())};
  in_slabs(std::ssize(level.voxels), threads, [&](std::int64_t first, std::int64_t last) {
    for (auto o = static_cast<std::size_t>(first); o < static_cast<std::size_t>(last); ++o) {
      const int least_level = bone.voxels[o] ? marrow_level : soft_level;
      level.voxels[o] = static_cast<float>(std::clamp<int>(hu.voxels[o], least_level, bone_level));
    }
  });
  return box_blurred(level, threads);
}

// Each steep voxel votes for the centres of the balls of radius least to most (mm) on whose surface it lies.
Volume<float> votes_for_centres(const Volume<float>& level, double least, double most, int threads) {
  const auto& g = level.grid;
  const double h = g.axes.col(0).norm();
  Volume<float> votes{g, std::vector<float>(g.count(), 0)};
  const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<double>(level.at(i, j, k));
  };
  // each thread counts the votes that fall into its own slices, in the order of the voters
  const auto reach = static_cast<std::int64_t>(most / h) + 1;
  const std::int64_t sy = g.size[0], sz = g.size[0] * g.size[1];
  in_slabs(g.size[2], threads, [&](std::int64_t first, std::int64_t last) {
    std::vector<float> rough(static_cast<std::size_t>(g.size[0]));  // a row's squared gradients, rounded
    for (std::int64_t k = std::max<std::int64_t>(1, first - reach); k < std::min(g.size[2] - 1, last + reach);
         ++k)
      for (std::int64_t j = 1; j + 1 < g.size[1]; ++j) {
        const float* const row = level.voxels.data() + g.offset(0, j, k);
        for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
          const float a = row[i + 1] - row[i - 1], b = row[i + sy] - row[i - sy],
                      c = row[i + sz] - row[i - sz];
          rough[static_cast<std::size_t>(i)] = (a * a + b * b + c * c) / 4;
        }
        for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
          if (rough[static_cast<std::size_t>(i)] < 0.999F * static_cast<float>(least_slope * least_slope))
            continue;
          const Vector3d slope =
              0.5 * Vector3d(at(i + 1, j, k) - at(i - 1, j, k), at(i, j + 1, k) - at(i, j - 1, k),
                             at(i, j, k + 1) - at(i, j, k - 1));
          const double steep = slope.norm();
          if (steep < least_slope) continue;
          for (double r = least; r <= most; r += h) {
            const Vector3d p =
                Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) +
                slope / steep * (r / h);
            const auto a = nearest_whole(p[0]), b = nearest_whole(p[1]), c = nearest_whole(p[2]);
            if (c >= first && c < last && g.holds(a, b, c))
              votes.at(a, b, c) += static_cast<float>(h * h / (4 * std::numbers::pi * r * r));
          }
        }
      }
  });
  return box_blurred(votes, threads);
}

// Voxels with more votes than their neighbours, in the order of the slices.
std::vector<FoundSphere> local_maxima(const Volume<float>& votes, double radius, int threads) {
  const auto& g = votes.grid;
  std::vector<std::vector<FoundSphere>> by_slice(static_cast<std::size_t>(g.size[2]));
  in_slabs(g.size[2], threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = std::max<std::int64_t>(1, first); k < std::min(g.size[2] - 1, last); ++k)
      for (std::int64_t j = 1; j + 1 < g.size[1]; ++j)
        for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
          const float v = votes.at(i, j, k);
          if (v < 0.02F) continue;
          bool top = true;
          for (std::int64_t c = -1; c <= 1 && top; ++c)
            for (std::int64_t b = -1; b <= 1 && top; ++b)
              for (std::int64_t a = -1; a <= 1; ++a)
                if (votes.at(i + a, j + b, k + c) > v) top = false;
          if (top) by_slice[static_cast<std::size_t>(k)].push_back({g.point(i, j, k), radius, v, 0});
        }
  });
  std::vector<FoundSphere> found;
  for (const auto& slice : by_slice) found.insert(found.end(), slice.begin(), slice.end());
  return found;
}

}  // namespace

std::vector<FoundSphere> vote_balls(const Volume<std::int16_t>& hu, const Mask& bone, double least,
                                    double most, double apart, int threads) {
  const Volume<float> votes = votes_for_centres(smooth_levels(hu, bone, threads), least, most, threads);
  std::vector<FoundSphere> found = local_maxima(votes, 0.5 * (least + most), threads);
  std::sort(found.begin(), found.end(),
            [](const FoundSphere& a, const FoundSphere& b) { return a.score > b.score; });
  std::vector<FoundSphere> kept;
  for (const auto& ball : found) {
    const bool near = std::any_of(kept.begin(), kept.end(), [&](const FoundSphere& other) {
      return (other.centre - ball.centre).norm() < apart;
    });
    if (!near) kept.push_back(ball);
  }
  return kept;
}

std::optional<FoundSphere> sphere_through(const std::vector<Vector3d>& points) {
  if (points.size() < 4) return std::nullopt;
  // p|^2 = 2 c.p + (r^2 - |c|^2), relative to the mean for good conditioning
  Vector3d mean = Vector3d::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const auto& p : points) {
    Eigen::Vector4d row;
    row << 2 * (p - mean), 1;
    normal += row * row.transpose();
    right += row * (p - mean).squaredNorm();
  }
  const auto solver = normal.ldlt();
  if (solver.info() != Eigen::Success || solver.vectorD().minCoeff() < 1e-9 * solver.vectorD().maxCoeff())
    return std::nullopt;
  const Eigen::Vector4d x = solver.solve(right);
  FoundSphere ball;
  ball.centre = mean + x.head<3>();
  ball.radius = std::sqrt(std::max(0.0, x[3] + x.head<3>().squaredNorm()));
  double sum = 0;
  for (const auto& p : points) sum += std::pow((p - ball.centre).norm() - ball.radius, 2);
  ball.deviation = std::sqrt(sum / static_cast<double>(points.size()));
  return ball;
}

namespace {

// a radius at which many rays have an edge, and their number
struct AgreedRadius {
  double radius = 0;
  int count = 0;
};

std::vector<AgreedRadius> agreed_radii(const std::vector<std::vector<double>>& edges, double least,
                                       double most) {
  const auto bins = static_cast<std::size_t>(most - least) + 2;
  std::vector<int> count(bins, 0);
  for (const auto& ray : edges)
    for (const double r : ray) ++count[static_cast<std::size_t>(r - least)];
  std::vector<AgreedRadius> peaks;
  std::vector<int> wide(bins, 0);
  for (std::size_t n = 0; n < bins; ++n)
    wide[n] = count[n] + (n > 0 ? count[n - 1] : 0) + (n + 1 < bins ? count[n + 1] : 0);
  for (std::size_t n = 0; n < bins; ++n)
    if (wide[n] > 0 && (n == 0 || wide[n] >= wide[n - 1]) && (n + 1 == bins || wide[n] > wide[n + 1]))
      peaks.push_back({least + static_cast<double>(n) + 0.5, wide[n]});
  return peaks;
}

// least squares on the edges nearest to the sphere, with a tightening tolerance
std::optional<FoundSphere> refined(const CloseUp& view, FoundSphere ball, double least, double most) {
  static const std::vector<Vector3d> rays = even_directions(500);
  const double tight = std::max(1.5, view.blur);
  for (int round = 0; round < 10; ++round) {
    const double tolerance = round < 4 ? 2 * tight : tight;
    std::vector<Vector3d> kept;
    for (const auto& u : rays) {
      double nearest = tolerance, at = -1;
      for (const double r : falls_along(view, ball.centre, u, std::max(least, ball.radius - 2 * tolerance),
                                        ball.radius + 2 * tolerance))
        if (std::abs(r - ball.radius) < nearest) nearest = std::abs(r - ball.radius), at = r;
      if (at > 0) kept.push_back(ball.centre + at * u);
    }
    const auto fit = sphere_through(kept);
    if (!fit || 5 * kept.size() < rays.size() || fit->radius < least || fit->radius > most)
      return std::nullopt;
    const double moved = (fit->centre - ball.centre).norm();
    ball = *fit;
    ball.score = static_cast<double>(kept.size()) / static_cast<double>(rays.size());
    if (round > 5 && moved < 0.05) break;
  }
  return ball;
}

// fraction of directions in which bone ends well inside the sphere, in soft tissue: the sphere spans two
// bones
double left_early(const CloseUp& view, const FoundSphere& ball) {
  static const std::vector<Vector3d> rays = even_directions(200);
  constexpr double soft = 130;
  int early = 0;
  for (const auto& u : rays) {
    const auto falls = falls_along(view, ball.centre, u, 5, ball.radius - std::max(2.0, 1.5 * view.blur));
    early += std::any_of(falls.begin(), falls.end(),
                         [&](double r) { return view.at(ball.centre + (r + view.blur) * u) < soft; });
  }
  return static_cast<double>(early) / static_cast<double>(rays.size());
}

}  // namespace

std::vector<FoundSphere> fit_balls(const GreyVolume& volume, const Vector3d& near, double least, double most,
                                   int threads) {
  static const std::vector<Vector3d> rays = even_directions(120);
  const CloseUp view = close_up(volume, near, most + 20);
  // starts around the place, each with the radii that its rays agree on
  struct Start {
    FoundSphere ball;
    int count;
  };
  std::array<std::vector<Start>, 125> about;
  in_turns(std::ssize(about), threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t n = first; n < last; ++n) {
      const Vector3d centre =
          near + 7 * Vector3d(static_cast<double>(n % 5 - 2), static_cast<double>(n / 5 % 5 - 2),
                              static_cast<double>(n / 25 - 2));
      std::vector<std::vector<double>> edges;
      for (const auto& u : rays) edges.push_back(falls_along(view, centre, u, least, most));
      for (const auto& peak : agreed_radii(edges, least, most))
        about[static_cast<std::size_t>(n)].push_back({{centre, peak.radius, 0, 0}, peak.count});
    }
  });
  std::vector<Start> starts;
  for (const auto& here : about) starts.insert(starts.end(), here.begin(), here.end());
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.count > b.count; });
  std::vector<FoundSphere> balls, tried;
  constexpr std::size_t most_tries = 40;
  for (const auto& start : starts) {
    if (tried.size() == most_tries) break;
    const auto like = [&](const FoundSphere& other, double apart, double radii) {
      return (other.centre - start.ball.centre).norm() < apart &&
             std::abs(other.radius - start.ball.radius) < radii;
    };
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const FoundSphere& other) { return like(other, 8, 2.5); }))
      continue;
    tried.push_back(start.ball);
  }
  std::vector<std::optional<FoundSphere>> measured(tried.size());
  in_turns(std::ssize(tried), threads, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n) {
      measured[n] = refined(view, tried[n], least, most);
      if (measured[n]) measured[n]->score *= 1 - left_early(view, *measured[n]);
    }
  });
  for (const auto& ball : measured) {
    if (!ball || ball->score < 0.25 || (ball->centre - near).norm() > 30) continue;
    const bool known = std::any_of(balls.begin(), balls.end(), [&](const FoundSphere& other) {
      return (other.centre - ball->centre).norm() < 2 && std::abs(other.radius - ball->radius) < 1;
    });
    if (!known) balls.push_back(*ball);
  }
  std::stable_sort(balls.begin(), balls.end(),
                   [](const FoundSphere& a, const FoundSphere& b) { return a.score > b.score; });
  return balls;
}

}  // namespace borelli
