#include "samples/phantom_voxels.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "samples/phantom_builder.hpp"
#include "samples/scanner_effects.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

struct Box {
  Vector3d low = Vector3d::Constant(1e30), high = Vector3d::Constant(-1e30);

  void hold(const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

// Bounding box of a solid in coordinates q = map * p - shift.
Box box_in(const EllipticStack& shape, const Matrix3d& map, const Vector3d& shift) {
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d local;
    for (int c = 0; c < 3; ++c) local[c] = corner >> c & 1 ? shape.box_high()[c] : shape.box_low()[c];
    box.hold(map * shape.frame().point(local) - shift);
  }
  return box;
}

// The index range, `first` to `last`, of a row of voxels that can lie in a solid, limited by its box and its
// planes. Voxel i is at start + i * step in the solid's own frame.
struct Row {
  Vector3d start, step;
  std::int64_t first, last;

  void limit(double value, double slope, double bound) {  // value + i * slope <= bound
    if (slope > 1e-12)
      last = std::min(last, static_cast<std::int64_t>(std::floor(std::min((bound - value) / slope, 1e9))));
    else if (slope < -1e-12)
      first = std::max(first, static_cast<std::int64_t>(std::ceil(std::max((bound - value) / slope, -1e9))));
    else if (value > bound)
      last = first - 1;
  }
};

// One solid prepared for a grid.
struct Placed {
  const EllipticStack* shape;
  Vector3d start;  // voxel (0, 0, 0) in the solid's frame
  Matrix3d step;   // columns: one step along i, j, k
  std::array<std::int64_t, 3> low, high;
  struct Plane {
    Vector3d normal;
    double offset;
  };
  std::vector<Plane> planes;  // cuts in the solid's frame

  Placed(const EllipticStack& s, const Grid& grid) : shape(&s) {
    const Frame& f = s.frame();
    start = f.local(grid.origin);
    step = f.axes.transpose() * grid.axes;
    const Matrix3d inverse = grid.axes.inverse();
    const Box box = box_in(s, inverse, inverse * grid.origin);
    for (int c = 0; c < 3; ++c) {
      const std::size_t u = static_cast<std::size_t>(c);
      low[u] = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(std::max(box.low[c], -1.0))));
      high[u] = std::min<std::int64_t>(grid.size[u] - 1,
                                       static_cast<std::int64_t>(std::ceil(std::min(box.high[c], 1e9))));
    }
    for (const HalfSpace& c : s.cuts())
      if (s.side(c) >= 0)
        planes.push_back({f.axes.transpose() * c.normal, c.offset - c.normal.dot(f.origin)});
  }

  bool empty() const { return low[0] > high[0] || low[1] > high[1] || low[2] > high[2]; }

  // Calls fill(i) for each voxel of row (j, k) whose centre lies in the stack (without cuts and hole) and
  // within its planes.
  template <class F>
  void row(std::int64_t j, std::int64_t k, const F& fill) const {
    Row r{start + step.col(1) * static_cast<double>(j) + step.col(2) * static_cast<double>(k), step.col(0),
          low[0], high[0]};
    for (int c = 0; c < 3; ++c) {
      r.limit(r.start[c], r.step[c], shape->box_high()[c]);
      r.limit(-r.start[c], -r.step[c], -shape->box_low()[c]);
    }
    for (const Plane& p : planes) r.limit(p.normal.dot(r.start), p.normal.dot(r.step), p.offset);
    if (r.first > r.last) return;
    if (std::abs(r.step.z()) < 1e-12) {
      // the row stays in one cross-section: its voxels in the ellipse are contiguous
      const Ellipse e = shape->section(std::clamp(r.start.z(), shape->low(), shape->high()));
      if (e.a <= 0 || e.b <= 0) return;
      const double ux = (r.start.x() - e.x) / e.a, uy = (r.start.y() - e.y) / e.b;
      const double vx = r.step.x() / e.a, vy = r.step.y() / e.b;
      const double vv = vx * vx + vy * vy, uv = ux * vx + uy * vy,
                   rest = uv * uv - vv * (ux * ux + uy * uy - 1);
      if (rest < 0) return;
      const double root = std::sqrt(rest);
      r.first = std::max(r.first, static_cast<std::int64_t>(std::ceil((-uv - root) / vv)));
      r.last = std::min(r.last, static_cast<std::int64_t>(std::floor((-uv + root) / vv)));
      for (std::int64_t i = r.first; i <= r.last; ++i) fill(i);
      return;
    }
    std::size_t piece = 0;
    for (std::int64_t i = r.first; i <= r.last; ++i) {
      const Vector3d p = r.start + static_cast<double>(i) * r.step;
      const Ellipse e = shape->section(p.z(), piece);
      const double u = (p.x() - e.x) * e.b, v = (p.y() - e.y) * e.a, ab = e.a * e.b;
      if (u * u + v * v <= ab * ab) fill(i);
    }
  }
};

// Writes, for slice k, the index + 1 of the innermost solid at each voxel's centre (0: none). Solids come
// parents first, so the last one that holds a point is the innermost.
class Painter {
 public:
  Painter(const std::vector<PhantomSolid>& solids, const Grid& grid) : grid_(grid) {
    for (std::size_t i = 0; i < solids.size(); ++i) {
      Placed placed(solids[i].shape, grid);
      if (placed.empty()) continue;
      placed_.push_back(std::move(placed));
      index_.push_back(static_cast<std::uint16_t>(i + 1));
    }
  }

  void slice(std::int64_t k, std::span<std::uint16_t> out) const {
    std::fill(out.begin(), out.end(), std::uint16_t{0});
    for (std::size_t n = 0; n < placed_.size(); ++n) {
      const Placed& p = placed_[n];
      if (k < p.low[2] || k > p.high[2]) continue;
      const EllipticStack* hole = p.shape->hole();
      for (std::int64_t j = p.low[1]; j <= p.high[1]; ++j) {
        std::uint16_t* const row = out.data() + j * grid_.size[0];
        p.row(j, k, [&](std::int64_t i) {
          if (hole && hole->holds(grid_.point({double(i), double(j), double(k)}))) return;
          row[i] = index_[n];
        });
      }
    }
  }

 private:
  Grid grid_;
  std::vector<Placed> placed_;
  std::vector<std::uint16_t> index_;
};

// Mean CT number over 4 x 4 x 4 points in each voxel.
std::vector<float> supersampled(const std::vector<PhantomSolid>& solids, const std::vector<int>& hu,
                                const Grid& grid, int threads) {
  constexpr int fine = 4;
  const std::size_t plane = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
  std::vector<Painter> painters;
  for (int s = 0; s < fine * fine * fine; ++s) {
    Grid shifted = grid;
    const Vector3d at(s % fine, s / fine % fine, s / (fine * fine));
    shifted.origin = grid.point((at.array() + 0.5) / fine - 0.5);
    painters.emplace_back(solids, shifted);
  }
  std::vector<float> mean(grid.count());
  each_slice(grid.size[2], threads, [&](std::int64_t k) {
    std::vector<std::uint16_t> index(plane);
    std::vector<std::int32_t> sum(plane, 0);
    for (const Painter& painter : painters) {
      painter.slice(k, index);
      for (std::size_t v = 0; v < plane; ++v) sum[v] += hu[index[v]];
    }
    float* const out = mean.data() + static_cast<std::size_t>(k) * plane;
    for (std::size_t v = 0; v < plane; ++v) out[v] = static_cast<float>(sum[v]) / (fine * fine * fine);
  });
  return mean;
}

// Visits points spread over the walls of the outermost solids, ignoring cuts.
template <class Visit>
void each_skin_point(const Phantom& phantom, const Visit& visit) {
  for (const PhantomSolid& solid : phantom.solids) {
    if (solid.parent >= 0) continue;
    for (int i = 0; i <= 60; ++i)
      for (int j = 0; j < 48; ++j) {
        const double h = solid.shape.low() + (solid.shape.high() - solid.shape.low()) * i / 60;
        const Ellipse e = solid.shape.section(h);
        const double angle = 2 * std::numbers::pi * j / 48;
        visit(solid.shape.frame().point({e.x + e.a * std::cos(angle), e.y + e.b * std::sin(angle), h}));
      }
  }
}

}  // namespace

std::vector<PhantomSolid> phantom_table(const Phantom& phantom) {
  constexpr double radius = 700, half_width = 230, gap = 3, shell = 2, core = 24;
  // place the trough's axis so that every point of the body keeps the gap
  double axis_y = -1e30, low = 1e30, high = -1e30;
  each_skin_point(phantom, [&](const Vector3d& p) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
    if (std::abs(p.x()) < half_width)
      axis_y = std::max(axis_y, p.y() - std::sqrt(radius * radius - p.x() * p.x()) + gap);
  });
  const auto trough = [&](double r) {
    return EllipticStack(Frame{}, {{low - 60, 0, axis_y, r, r}, {high + 60, 0, axis_y, r, r}});
  };
  const double edge = axis_y + std::sqrt(radius * radius - half_width * half_width);
  const HalfSpace behind{-Vector3d::UnitY(), -edge};
  std::vector<PhantomSolid> solids;
  solids.push_back(
      {"table", trough(radius + core).hollowed(trough(radius)).cut(behind), tissue::table, 0, 0, -1});
  PhantomTissue foam = tissue::air;
  foam.hu = -940;
  solids.push_back({"table core",
                    trough(radius + core - shell)
                        .hollowed(trough(radius + shell))
                        .cut(HalfSpace{-Vector3d::UnitY(), -edge - shell}),
                    foam, 0, 0, 0});
  return solids;
}

PhantomSolid phantom_blanket(const Phantom& phantom) {
  constexpr double thick = 6, half_width = 260;
  double front = 1e30, back = -1e30;
  each_skin_point(phantom, [&](const Vector3d& p) {
    if (std::abs(p.x()) < 120 && p.z() < phantom.landmarks.at("suprasternale").point.z())
      front = std::min(front, p.y());
    back = std::max(back, p.y());
  });
  const double low = -40, high = phantom.landmarks.at("xiphion").point.z();
  const double deep = back - front;
  const auto tube = [&](double more) {
    return EllipticStack(Frame{}, {{low, 0, back, half_width + more, deep + more},
                                   {high, 0, back, half_width + more, deep + more}});
  };
  return {
      "blanket", tube(thick).hollowed(tube(0)).cut(HalfSpace{Vector3d::UnitY(), back}), tissue::blanket, 0, 0,
      -1};
}

Result<void> check_scan(const GridOptions& grid, const ScanOptions& scan) {
  struct Bounded {
    const char *name, *unit;
    double value, least, most;
  };
  std::vector<Bounded> all{
      {"tilt", " degrees", grid.tilt_deg, -45, 45}, {"margin", " mm", grid.margin, 0, 500},
      {"blur", " mm", scan.blur_mm, 0, 20},         {"noise", " HU", scan.noise_hu, 0, 1000},
      {"streaks", " HU", scan.streaks_hu, 0, 3000}, {"field of view", " mm", scan.field_of_view, 0, 2000}};
  for (int c = 0; c < 3; ++c) {
    all.push_back({"spacing", " mm", grid.spacing[c], 0.2, 50});
    all.push_back({"rotation", " degrees", grid.rotation_deg[c], -180, 180});
    all.push_back({"offset", " voxels", grid.offset[c], -1, 1});
  }
  for (const Bounded& b : all)
    if (!(b.value >= b.least && b.value <= b.most))  // also refuses NaN
      return bad_use(b.name, fmt::format("{:g}{} is out of range; give {:g} to {:g}{}", b.value, b.unit,
                                         b.least, b.most, b.unit));
  return {};
}

Grid phantom_grid(const Phantom& phantom, const GridOptions& options, bool table) {
  const auto turn = [&](int axis) {
    return Eigen::AngleAxisd(options.rotation_deg[axis] * std::numbers::pi / 180, Vector3d::Unit(axis));
  };
  Matrix3d directions = (turn(2) * turn(1) * turn(0)).toRotationMatrix();
  if (options.rotation_deg.isZero()) directions.setIdentity();
  Grid grid;
  grid.axes = directions * options.spacing.asDiagonal();
  grid.axes.col(2) +=
      directions.col(1) * std::tan(options.tilt_deg * std::numbers::pi / 180) * options.spacing.z();
  const Matrix3d inverse = grid.axes.inverse();
  Box box;
  for (const PhantomSolid& solid : phantom.solids) {
    if (solid.parent >= 0) continue;
    const Box own = box_in(solid.shape, inverse, Vector3d::Zero());
    box.hold(own.low);
    box.hold(own.high);
  }
  if (table)
    for (const PhantomSolid& solid : phantom_table(phantom)) {
      // the trough is a small part of its circle: include its corners, as long as the body
      for (const double x : {-232.0, 232.0})
        for (const double z : {0.0, phantom.landmarks.at("vertex").point.z()}) {
          const Ellipse e = solid.shape.section(z);
          box.hold(inverse * Vector3d(x, e.y + e.b, z));
        }
    }
  const Vector3d margin = Vector3d::Constant(options.margin).cwiseQuotient(options.spacing);
  Vector3d first = (box.low - margin).array().floor() - 1;
  Vector3d last = (box.high + margin).array().ceil();
  Box kept;  // the scanned box, in voxels
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d p;
    for (int c = 0; c < 3; ++c) p[c] = corner >> c & 1 ? options.crop_high[c] : options.crop_low[c];
    kept.hold(inverse * p);
  }
  first = first.cwiseMax(kept.low.array().ceil().matrix());
  last = last.cwiseMin((kept.high.array().floor() - 1).matrix());
  // voxel faces, not centres, pass through the patient origin: so soles on the floor end between two layers,
  // and left and right are symmetric
  grid.origin = grid.axes * (first + Vector3d::Constant(0.5) + options.offset);
  for (int c = 0; c < 3; ++c)
    grid.size[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(last[c] - first[c]) + 1;
  return grid;
}

double bytes_of_scan(const Grid& grid, const ScanOptions& options) {
  const bool has_fractions =
      options.partial_volume || options.blur_mm > 0 || options.noise_hu > 0 || options.streaks_hu > 0;
  double bytes = has_fractions ? 7 : 3;  // per voxel: int16 CT number, uint8 label, float if needed
  for (const auto size : grid.size) bytes *= static_cast<double>(size);
  return bytes;
}

Scan voxelise(const Phantom& phantom, const Grid& grid, const ScanOptions& options) {
  std::vector<PhantomSolid> solids;  // table and blanket first: the body takes precedence
  if (options.blanket) solids.push_back(phantom_blanket(phantom));
  if (options.table)
    for (const PhantomSolid& solid : phantom_table(phantom)) solids.push_back(solid);
  solids.insert(solids.end(), phantom.solids.begin(), phantom.solids.end());
  std::vector<int> hu{-1000};
  std::vector<std::uint8_t> label{0};
  for (const PhantomSolid& solid : solids) {
    hu.push_back(solid.tissue.hu);
    label.push_back(static_cast<std::uint8_t>(solid.part));
  }

  Scan scan;
  scan.grey.grid = scan.labels.grid = grid;
  scan.grey.voxels.resize(grid.count());
  scan.labels.voxels.resize(grid.count());
  for (const Part& part : parts) scan.labels.names.emplace_back(part.name);
  const Painter painter(solids, grid);
  const std::size_t plane = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
  each_slice(grid.size[2], options.threads, [&](std::int64_t k) {
    std::vector<std::uint16_t> index(plane);
    painter.slice(k, index);
    const std::size_t begin = static_cast<std::size_t>(k) * plane;
    for (std::size_t v = 0; v < plane; ++v) {
      scan.grey.voxels[begin + v] = static_cast<std::int16_t>(hu[index[v]]);
      scan.labels.voxels[begin + v] = label[index[v]];
    }
  });
  if (!options.partial_volume && options.blur_mm <= 0 && options.noise_hu <= 0 && options.streaks_hu <= 0) {
    limit_view(scan, options.field_of_view, options.threads);
    return scan;
  }

  std::vector<float> value;
  if (options.partial_volume)
    value = supersampled(solids, hu, grid, options.threads);
  else
    value.assign(scan.grey.voxels.begin(), scan.grey.voxels.end());
  add_scanner_effects(std::move(value), options, scan);
  return scan;
}

}  // namespace borelli
