#include "samples/elliptic_stack.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "samples/disc_moments.hpp"

namespace borelli {
namespace {

using Eigen::Matrix4d, Eigen::Vector2d, Eigen::Vector3d;
using Numbers = Eigen::Array<double, 1, 5>;  // x, y, a, b, inset

Numbers numbers(const Section& s) { return {s.x, s.y, s.a, s.b, s.inset}; }

// Slopes at the knots: the weighted harmonic mean of the adjacent secants (Fritsch & Butland), 0 if they
// differ in sign; at the ends the end secant.
std::vector<Numbers> monotone_slopes(const std::vector<Section>& s) {
  const std::size_t n = s.size();
  std::vector<Numbers> secant(n - 1), slope(n);
  for (std::size_t i = 0; i + 1 < n; ++i)
    secant[i] = (numbers(s[i + 1]) - numbers(s[i])) / (s[i + 1].height - s[i].height);
  slope.front() = secant.front();
  slope.back() = secant.back();
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = s[i].height - s[i - 1].height, after = s[i + 1].height - s[i].height;
    for (int c = 0; c < 5; ++c) {
      const double p = secant[i - 1][c], q = secant[i][c];
      const double w1 = 2 * after + before, w2 = after + 2 * before;
      slope[i][c] = p * q > 0 ? (w1 + w2) / (w1 / p + w2 / q) : 0.0;
    }
  }
  return slope;
}

// Gauss-Kronrod 7-15 nodes and weights on [-1, 1] (Piessens et al., QUADPACK, 1983)
constexpr std::array<double, 8> kronrod_node{
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144144693013, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0};
constexpr std::array<double, 8> kronrod_weight{
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr std::array<double, 4> gauss_weight{
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
    0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

// Moments of one cross-section, including height: integral of q qT dA, q = (x, y, height, 1).
using Slice = Matrix4d;

// Moments of the ellipse `e` at `height`, cut by planes given in the stack's frame.
Slice slice_moments(const Ellipse& e, double height, const std::vector<HalfSpace>& cuts) {
  std::array<HalfPlane, most_cuts> lines;
  std::size_t count = 0;
  for (const HalfSpace& c : cuts) {
    const Vector2d n(c.normal.x() * e.a, c.normal.y() * e.b);
    const double norm = n.norm();
    const double room = c.offset - c.normal.z() * height - c.normal.x() * e.x - c.normal.y() * e.y;
    if (norm > 0)
      lines[count++] = {n / norm, room / norm};
    else if (room < 0)
      return Slice::Zero();
  }
  // the ellipse is the unit disc stretched to a and b and moved to x, y
  const PlaneMoments m = disc_moments({lines.data(), count}) * (e.a * e.b);
  const double h = height, x = e.x * m[0] + e.a * m[1], y = e.y * m[0] + e.b * m[2];
  const double xx = e.x * e.x * m[0] + 2 * e.x * e.a * m[1] + e.a * e.a * m[3];
  const double yy = e.y * e.y * m[0] + 2 * e.y * e.b * m[2] + e.b * e.b * m[4];
  const double xy = e.x * e.y * m[0] + e.x * e.b * m[2] + e.a * e.y * m[1] + e.a * e.b * m[5];
  Slice s;
  s << xx, xy, x * h, x, xy, yy, y * h, y, x * h, y * h, m[0] * h * h, m[0] * h, x, y, m[0] * h, m[0];
  return s;
}

template <class F>
std::pair<Slice, double> kronrod(const F& slice, double from, double to, const Matrix4d& scale) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  Slice fine = Slice::Zero(), coarse = Slice::Zero();
  for (std::size_t i = 0; i < 8; ++i)
    for (const double sign : {-1.0, 1.0}) {
      if (i == 7 && sign > 0) continue;  // the middle node counts once
      const Slice value = slice(middle + sign * half * kronrod_node[i]);
      fine += kronrod_weight[i] * value;
      if (i % 2 == 1) coarse += gauss_weight[i / 2] * value;
    }
  fine *= half;
  coarse *= half;
  return {fine, ((fine - coarse).array().abs() * scale.array()).maxCoeff()};
}

template <class F>
Slice integrate(const F& slice, double from, double to, const Matrix4d& scale, double allowed, int depth) {
  const auto [value, error] = kronrod(slice, from, to, scale);
  if (!(error > allowed) || depth == 0) return value;  // the comparison also ends on NaN
  const double middle = 0.5 * (from + to);
  return integrate(slice, from, middle, scale, 0.7 * allowed, depth - 1) +
         integrate(slice, middle, to, scale, 0.7 * allowed, depth - 1);
}

}  // namespace

EllipticStack::EllipticStack(Frame frame, std::vector<Section> sections, double low_cap, double high_cap,
                             double tip_inset)
    : frame_(std::move(frame)),
      sections_(std::move(sections)),
      low_cap_(low_cap > 0 ? low_cap - tip_inset : 0),
      high_cap_(high_cap > 0 ? high_cap - tip_inset : 0),
      low_(sections_.front().height + (low_cap > 0 ? tip_inset : 0)),
      high_(sections_.back().height - (high_cap > 0 ? tip_inset : 0)) {
  fit();
}

void EllipticStack::fit() {
  const std::vector<Numbers> slope = monotone_slopes(sections_);
  pieces_.clear();
  const double inf = std::numeric_limits<double>::infinity();
  box_low_ = {inf, inf, low_};
  box_high_ = {-inf, -inf, high_};
  for (std::size_t i = 0; i + 1 < sections_.size(); ++i) {
    const Section &s = sections_[i], &next = sections_[i + 1];
    const double width = next.height - s.height;
    const Numbers rise = (numbers(next) - numbers(s)) / width;
    Piece piece;
    piece.from = s.height;
    piece.c.row(0) = numbers(s);
    piece.c.row(1) = slope[i];
    piece.c.row(2) = (3 * rise - 2 * slope[i] - slope[i + 1]) / width;
    piece.c.row(3) = (slope[i] + slope[i + 1] - 2 * rise) / (width * width);
    pieces_.push_back(piece);
    // every number is monotone between two knots
    const double a = std::max(s.a, next.a) - std::min(s.inset, next.inset);
    const double b = std::max(s.b, next.b) - std::min(s.inset, next.inset);
    box_low_.head<2>() =
        box_low_.head<2>().cwiseMin(Vector2d(std::min(s.x, next.x) - a, std::min(s.y, next.y) - b));
    box_high_.head<2>() =
        box_high_.head<2>().cwiseMax(Vector2d(std::max(s.x, next.x) + a, std::max(s.y, next.y) + b));
  }
  for (const HalfSpace& c : cuts_) bound(c);
}

void EllipticStack::bound(const HalfSpace& cut) {
  const Vector3d n = frame_.axes.transpose() * cut.normal;
  const double offset = cut.offset - cut.normal.dot(frame_.origin);
  for (int c = 0; c < 3; ++c) {
    if (std::abs(std::abs(n[c]) - 1) > 1e-12) continue;
    // slightly wider, for the rounding of the rotation
    if (n[c] > 0)
      box_high_[c] = std::max(box_low_[c], std::min(box_high_[c], offset + 1e-9));
    else
      box_low_[c] = std::min(box_high_[c], std::max(box_low_[c], -offset - 1e-9));
  }
}

EllipticStack EllipticStack::cut(const HalfSpace& half_space) const {
  EllipticStack result = *this;
  const bool known = std::any_of(cuts_.begin(), cuts_.end(), [&](const HalfSpace& c) {
    return c.normal == half_space.normal && c.offset == half_space.offset;
  });
  if (!known) {
    if (cuts_.size() == most_cuts) throw std::length_error("an elliptic stack has at most 16 cuts");
    result.cuts_.push_back(half_space);
    result.bound(half_space);
  }
  return result;
}

EllipticStack EllipticStack::cut(const std::vector<HalfSpace>& half_spaces) const {
  EllipticStack result = *this;
  for (const HalfSpace& h : half_spaces) result = result.cut(h);
  return result;
}

EllipticStack EllipticStack::hollowed(const EllipticStack& hole) const {
  EllipticStack result = *this;
  result.hole_ = std::make_shared<const EllipticStack>(hole);
  return result;
}

EllipticStack EllipticStack::moved(const Frame& frame) const {
  EllipticStack result = *this;
  result.frame_ = frame.then(frame_);
  for (HalfSpace& c : result.cuts_) {
    c.normal = frame.axes * c.normal;
    c.offset += c.normal.dot(frame.origin);
  }
  if (hole_) result.hole_ = std::make_shared<const EllipticStack>(hole_->moved(frame));
  return result;
}

EllipticStack EllipticStack::scaled(double factor) const {
  EllipticStack result = *this;
  result.frame_.origin *= factor;
  for (Section& s : result.sections_)
    s = {s.height * factor, s.x * factor, s.y * factor, s.a * factor, s.b * factor, s.inset * factor};
  for (double* length : {&result.low_, &result.high_, &result.low_cap_, &result.high_cap_}) *length *= factor;
  for (HalfSpace& c : result.cuts_) c.offset *= factor;
  if (hole_) result.hole_ = std::make_shared<const EllipticStack>(hole_->scaled(factor));
  result.fit();
  return result;
}

EllipticStack EllipticStack::shrunk(double depth) const {
  EllipticStack result = *this;
  for (Section& s : result.sections_) s.inset += depth;
  if (low_cap_ > 0) result.low_cap_ -= depth, result.low_ += depth;
  if (high_cap_ > 0) result.high_cap_ -= depth, result.high_ -= depth;
  result.hole_.reset();
  result.fit();
  return result;
}

Ellipse EllipticStack::section(double height, std::size_t& at) const {
  while (at > 0 && height < pieces_[at].from) --at;
  while (at + 1 < pieces_.size() && height >= pieces_[at + 1].from) ++at;
  const Piece* const piece = &pieces_[at];
  const double t = height - piece->from;
  const auto& c = piece->c;
  const auto value = [&](int k) { return c(0, k) + t * (c(1, k) + t * (c(2, k) + t * c(3, k))); };
  double round = 1;  // factor by which a rounded end narrows the ellipse
  if (height < low_ + low_cap_) {
    const double u = (low_ + low_cap_ - height) / low_cap_;
    round *= std::sqrt(std::max(0.0, 1 - u * u));
  }
  if (height > high_ - high_cap_) {
    const double u = (height - high_ + high_cap_) / high_cap_;
    round *= std::sqrt(std::max(0.0, 1 - u * u));
  }
  const double inset = value(4);
  return {value(0), value(1), round * std::max(0.0, value(2) - inset),
          round * std::max(0.0, value(3) - inset)};
}

bool EllipticStack::holds(const Vector3d& point) const {
  const Vector3d p = frame_.local(point);
  if (p.z() < low_ || p.z() > high_) return false;
  const Ellipse e = section(p.z());
  const double u = (p.x() - e.x) * e.b, v = (p.y() - e.y) * e.a, ab = e.a * e.b;
  if (u * u + v * v > ab * ab) return false;
  for (const HalfSpace& c : cuts_)
    if (!c.holds(point)) return false;
  return !hole_ || !hole_->holds(point);
}

int EllipticStack::side(const HalfSpace& half_space) const {
  const Vector3d n = frame_.axes.transpose() * half_space.normal;
  const double offset = half_space.offset - half_space.normal.dot(frame_.origin);
  const Vector3d middle = 0.5 * (box_low_ + box_high_), half = 0.5 * (box_high_ - box_low_);
  const double reach = n.cwiseAbs().dot(half), at = n.dot(middle);
  if (at + reach <= offset) return -1;
  return at - reach >= offset ? 1 : 0;
}

Matrix4d EllipticStack::local_moments() const {
  // cuts in the stack's own frame; a cut normal to the axis only shortens the integration interval
  double from = low_, to = high_;
  std::vector<HalfSpace> cuts;
  for (const HalfSpace& c : cuts_) {
    if (side(c) < 0) continue;
    const Vector3d n = frame_.axes.transpose() * c.normal;
    const double offset = c.offset - c.normal.dot(frame_.origin);
    if (n.head<2>().norm() > 1e-9)
      cuts.push_back({n, offset});
    else if (n.z() > 0)
      to = std::min(to, offset / n.z());
    else
      from = std::max(from, offset / n.z());
  }
  Matrix4d sum = Matrix4d::Zero();
  if (to <= from || (box_high_ - box_low_).minCoeff() <= 0) return sum;
  // errors are relative to the solid's extent from the frame's origin
  const Vector3d reach = box_low_.cwiseAbs().cwiseMax(box_high_.cwiseAbs()).cwiseMax(1e-3);
  const Eigen::Vector4d unit(reach.x(), reach.y(), reach.z(), 1);
  const double box = std::max((box_high_ - box_low_).prod(), 1e-2);
  const Matrix4d scale = (unit * unit.transpose()).cwiseInverse() / box;
  // between these heights the integrand is smooth, except where a cut begins to touch the wall
  std::vector<double> knots{from, to, low_ + low_cap_, high_ - high_cap_};
  for (const Section& s : sections_) knots.push_back(s.height);
  std::sort(knots.begin(), knots.end());
  const auto slice = [&](double height) { return slice_moments(section(height), height, cuts); };
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double begin = std::clamp(knots[i], from, to), end = std::clamp(knots[i + 1], from, to);
    if (end > begin) sum += integrate(slice, begin, end, scale, 1e-12, 40);
  }
  return sum;
}

Matrix4d EllipticStack::moments() const {
  Matrix4d place = Matrix4d::Identity();
  place.topLeftCorner<3, 3>() = frame_.axes;
  place.topRightCorner<3, 1>() = frame_.origin;
  Matrix4d result = place * local_moments() * place.transpose();
  if (hole_) result -= hole_->cut(cuts_).moments();
  return result;
}

Eigen::Matrix3d axes_along(const Vector3d& axis, const Vector3d& x_hint) {
  const Vector3d z = axis.normalized();
  Vector3d x = x_hint - x_hint.dot(z) * z;
  if (x.norm() < 1e-6 * x_hint.norm()) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return axes;
}

EllipticStack ellipsoid(const Vector3d& centre, const Vector3d& semi_axes, const Eigen::Matrix3d& axes) {
  const double a = semi_axes.x(), b = semi_axes.y(), c = semi_axes.z();
  return EllipticStack({axes, centre}, {{-c, 0, 0, a, b}, {c, 0, 0, a, b}}, c, c);
}

EllipticStack capsule(const Vector3d& from, const Vector3d& to, double radius) {
  const double length = (to - from).norm();
  const Frame frame{axes_along(to - from, Vector3d::UnitX()), from};
  return EllipticStack(frame, {{-radius, 0, 0, radius, radius}, {length + radius, 0, 0, radius, radius}},
                       radius, radius);
}

EllipticStack cone(const Vector3d& from, const Vector3d& to, const Vector2d& from_semi,
                   const Vector2d& to_semi, const Vector3d& x_hint) {
  const Frame frame{axes_along(to - from, x_hint), from};
  return EllipticStack(
      frame, {{0, 0, 0, from_semi.x(), from_semi.y()}, {(to - from).norm(), 0, 0, to_semi.x(), to_semi.y()}});
}

}  // namespace borelli
