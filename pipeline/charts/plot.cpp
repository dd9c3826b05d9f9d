#include "pipeline/charts/plot.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "error/plain_cell.hpp"
#include "inertia/csv.hpp"
#include "pipeline/charts/plot_scale.hpp"
#include "pipeline/charts/plot_style.hpp"

namespace borelli {
namespace {

constexpr double width = 720, left = 78, right = 22, plot_height = 300;
constexpr double character = 6.8;  // mean advance of the 12 px sans-serif text, rather too wide

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '\'')
      out += "&#39;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

std::string superscript(int exponent) {
  constexpr std::array<std::string_view, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) out += digits[c - '0'];
  return out;
}

// 0.001 to 99999 as they are, the rest (and all powers of ten on a logarithmic axis) as 2×10⁻⁶.
std::string tick_text(double value, bool logarithmic) {
  const double size = std::abs(value);
  if (size == 0) return "0";
  if (value < 0) return "−" + tick_text(size, logarithmic);
  if (logarithmic ? size >= 0.1 && size < 1e3 : size >= 1e-3 && size < 1e5)
    return fmt::format("{:.6g}", value);
  const int exponent = static_cast<int>(std::floor(std::log10(size) + 1e-12));
  const double factor = value / std::pow(10, exponent);
  if (std::abs(factor - 1) < 1e-9) return "10" + superscript(exponent);
  return fmt::format("{:.3g}×10{}", factor, superscript(exponent));
}

struct Point {
  double x, y;
};

// Keeps only the first, lowest, highest and last point of each half-pixel column: no more is visible.
std::vector<Point> thinned(const std::vector<Point>& line) {
  if (line.size() < 2000) return line;
  std::vector<Point> out;
  for (std::size_t i = 0; i < line.size();) {
    std::size_t end = i, low = i, high = i;
    while (end < line.size() && std::floor(2 * line[end].x) == std::floor(2 * line[i].x)) {
      if (line[end].y < line[low].y) low = end;
      if (line[end].y > line[high].y) high = end;
      ++end;
    }
    std::array<std::size_t, 4> keep{i, std::min(low, high), std::max(low, high), end - 1};
    for (std::size_t k = 0; k < 4; ++k)
      if (k == 0 || keep[k] != keep[k - 1]) out.push_back(line[keep[k]]);
    i = end;
  }
  return out;
}

// The pieces of a curve between undrawable values, in the drawing's pixels.
std::vector<std::vector<Point>> pieces(const Curve& curve, const PlotScale& x, const PlotScale& y,
                                       double top) {
  std::vector<std::vector<Point>> out(1);
  for (std::size_t i = 0; i < std::min(curve.x.size(), curve.y.size()); ++i) {
    const double u = x.at(curve.x[i]), v = y.at(curve.y[i]);
    if (!std::isfinite(u) || !std::isfinite(v)) {
      if (!out.back().empty()) out.emplace_back();
      continue;
    }
    // far outside the frame coordinates are clamped: a diverging run would overflow the viewer's numbers
    out.back().push_back({left + std::clamp(u, -10., 10.) * (width - left - right),
                          top + (1 - std::clamp(v, -10., 10.)) * plot_height});
  }
  if (out.back().empty()) out.pop_back();
  for (auto& piece : out) piece = thinned(piece);
  return out;
}

void draw_axes(std::string& out, const Plot& plot, const PlotScale& x, const PlotScale& y, double top) {
  const double bottom = top + plot_height, far = width - right;
  for (const double tick : x.ticks) {
    const double u = left + x.at(tick) * (far - left);
    out += fmt::format("<path class='grid' d='M{:.2f} {:.2f}V{:.2f}'/>\n", u, top, bottom);
    out += fmt::format("<path class='axis' d='M{:.2f} {:.2f}v5'/>\n", u, bottom);
    out += fmt::format("<text x='{:.2f}' y='{:.2f}' text-anchor='middle'>{}</text>\n", u, bottom + 19,
                       tick_text(tick, x.logarithmic));
  }
  for (const double tick : y.ticks) {
    const double v = bottom - y.at(tick) * plot_height;
    out += fmt::format("<path class='grid' d='M{:.2f} {:.2f}H{:.2f}'/>\n", left, v, far);
    out += fmt::format("<path class='axis' d='M{:.2f} {:.2f}h-5'/>\n", left, v);
    out += fmt::format("<text x='{:.2f}' y='{:.2f}' text-anchor='end'>{}</text>\n", left - 9, v + 4,
                       tick_text(tick, y.logarithmic));
  }
  out += fmt::format("<rect class='frame' x='{}' y='{:.2f}' width='{}' height='{}'/>\n", left, top,
                     far - left, plot_height);
  out += fmt::format("<text x='{:.2f}' y='{:.2f}' text-anchor='middle'>{}</text>\n", (left + far) / 2,
                     bottom + 41, escaped(plot.x.label));
  out += fmt::format("<text transform='translate(18 {:.2f}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                     (top + bottom) / 2, escaped(plot.y.label));
}

// A dot, square or triangle of equal visual weight.
std::string mark(double x, double y, const CurveStyle& style, bool hollow) {
  const std::string paint =
      fmt::format("stroke='{}' fill='{}'", style.colour, hollow ? "#fff" : style.colour);
  if (style.shape == 0) return fmt::format("<circle cx='{:.2f}' cy='{:.2f}' r='3.2' {}", x, y, paint);
  if (style.shape == 1)
    return fmt::format("<rect x='{:.2f}' y='{:.2f}' width='6' height='6' {}", x - 3, y - 3, paint);
  return fmt::format("<path d='M{:.2f} {:.2f}l3.8 6.6h-7.6z' {}", x, y - 4.2, paint);
}

std::string_view mark_element(const CurveStyle& style) {
  return style.shape == 0 ? "circle" : style.shape == 1 ? "rect" : "path";
}

// Completes an element, with its tip.
std::string closed(const std::string& element, std::string_view name, const std::string& tip) {
  return tip.empty() ? element + "/>\n"
                     : fmt::format("{}><title>{}</title></{}>\n", element, escaped(tip), name);
}

std::string points_of(const std::vector<Point>& piece) {
  std::string out;
  for (const Point& p : piece) out += fmt::format("{:.2f},{:.2f} ", p.x, p.y);
  // (a polyline of one point draws nothing; two points give a dot as broad as the line)
  return piece.size() == 1 ? out + fmt::format("{:.2f},{:.2f} ", piece[0].x + 0.01, piece[0].y) : out;
}

/// A white outline that separates a curve from tiles.
void draw_halo(std::string& out, const Curve& curve, const PlotScale& x, const PlotScale& y, double top) {
  out += fmt::format("<g data-curve='{}'>\n", escaped(curve.name));
  for (const auto& piece : pieces(curve, x, y, top))
    out += fmt::format("<polyline class='halo' stroke='#fff' stroke-dasharray='none' points='{}'/>\n",
                       points_of(piece));
  out += "</g>\n";
}

void draw_curve(std::string& out, const Curve& curve, const CurveStyle& style, const PlotScale& x,
                const PlotScale& y, double top) {
  out += fmt::format("<g data-curve='{}'>\n", escaped(curve.name));
  for (const auto& piece : pieces(curve, x, y, top)) {
    out += fmt::format("<polyline class='{}' stroke='{}' stroke-dasharray='{}' points='{}'/>\n",
                       curve.faint   ? "faint"
                       : curve.broad ? "broad"
                                     : "curve",
                       style.colour, style.dash, points_of(piece));
  }
  for (std::size_t i = 0; curve.marks && i < std::min(curve.x.size(), curve.y.size()); ++i) {
    const double u = x.at(curve.x[i]), v = y.at(curve.y[i]);
    if (!std::isfinite(u) || !std::isfinite(v)) continue;
    out += closed(mark(left + u * (width - left - right), top + (1 - v) * plot_height, style,
                       i < curve.hollow.size() && curve.hollow[i]),
                  mark_element(style), i < curve.tips.size() ? curve.tips[i] : "");
  }
  out += "</g>\n";
}

// A box around a point, with half its width and height.
struct TextBox {
  Point at;
  double wide, high;
};

bool overlap(const TextBox& a, const TextBox& b) {
  return std::abs(a.at.x - b.at.x) < a.wide + b.wide && std::abs(a.at.y - b.at.y) < a.high + b.high;
}

// Numbers of faint curves. Each stands beside the last of its points that has room: clear of all dots, of the
// crosses at the edge and of other numbers.
void draw_numbers(std::string& out, const Plot& plot, const PlotScale& x, const PlotScale& y, double top) {
  constexpr double dot = 4.5, high = 4.5;  // includes a white pixel around
  // positions of a number relative to its point, best first
  constexpr std::array<Point, 8> beside{
      {{1, -1}, {1, 1}, {-1, -1}, {-1, 1}, {0, -1}, {0, 1}, {1, 0}, {-1, 0}}};
  std::vector<TextBox> taken;
  const auto place = [&](const Curve& curve, std::size_t i) {
    return Point{left + x.at(curve.x[i]) * (width - left - right),
                 top + (1 - y.at(curve.y[i])) * plot_height};
  };
  for (const Curve& curve : plot.curves)
    for (std::size_t i = 0; curve.marks && i < std::min(curve.x.size(), curve.y.size()); ++i)
      if (const Point p = place(curve, i); std::isfinite(p.x) && std::isfinite(p.y))
        taken.push_back({p, dot, dot});
  for (const EdgeMark& m : plot.edge)
    if (const double u = x.at(m.x); std::isfinite(u))
      taken.push_back({{left + std::clamp(u, 0., 1.) * (width - left - right), top + 8}, dot, dot});
  const auto room_for = [&](const TextBox& box) {
    return box.at.x - box.wide > left && box.at.x + box.wide < width - right && box.at.y - box.high > top &&
           box.at.y + box.high < top + plot_height &&
           std::none_of(taken.begin(), taken.end(),
                        [&](const TextBox& other) { return overlap(box, other); });
  };
  const auto draw = [&](const Curve& curve) {
    const double wide = 2.6 * double(std::to_string(curve.number).size()) + 1;
    for (std::size_t i = curve.x.size(); i-- > 0;) {
      const Point p = place(curve, i);
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      for (const Point& side : beside) {
        const double up = side.x == 0 ? high + dot + 0.1 : 4;
        const TextBox box{{p.x + side.x * (wide + dot + 0.1), p.y + side.y * up}, wide, high};
        if (!room_for(box)) continue;
        taken.push_back(box);
        out += fmt::format(
            "<g data-curve='{}'><text class='number' x='{:.2f}' y='{:.2f}' "
            "text-anchor='middle'>{}</text></g>\n",
            escaped(curve.name), box.at.x, box.at.y + 3, curve.number);
        return;
      }
    }
  };
  for (const Curve& curve : plot.curves)
    if (curve.number > 0) draw(curve);
}

void draw_edge(std::string& out, const std::vector<EdgeMark>& edge, const PlotScale& x, double top) {
  for (const EdgeMark& m : edge) {
    const double u = x.at(m.x), wide = width - left - right;
    if (!std::isfinite(u)) continue;
    out += fmt::format("<g data-curve='{}'>", escaped(m.curve)) +
           closed(fmt::format("<path class='cross' d='M{:.2f} {:.2f}l8 8m-8 0l8 -8'",
                              left + std::clamp(u * wide - 4, 2., wide - 10), top + 4),
                  "path", m.tip) +
           "</g>\n";
  }
}

// Number of characters, not bytes, of a UTF-8 text.
std::size_t letters(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

// Hatching patterns of kinds; `frame` makes their ids unique among several plots on one page.
std::string patterns(std::size_t frame) {
  std::string out;
  for (std::size_t kind = 0; kind < tile_fills.size(); ++kind)
    if (!tile_fills[kind].hatch.empty())
      out += fmt::format(
          "<pattern id='hatch{}_{:x}' width='8' height='8' patternUnits='userSpaceOnUse'><rect width='8' "
          "height='8' fill='{}'/><path class='hatch' d='{}'/></pattern>\n",
          kind, frame, tile_fills[kind].colour, tile_fills[kind].hatch);
  return out;
}

std::string paint_of(std::size_t kind, std::size_t frame) {
  return tile_fills.at(kind).hatch.empty() ? std::string(tile_fills[kind].colour)
                                           : fmt::format("url(#hatch{}_{:x})", kind, frame);
}

void draw_tiles(std::string& out, const Plot& plot, const PlotScale& x, const PlotScale& y, double top,
                std::size_t frame) {
  for (std::size_t kind = 0; kind < plot.kinds.size(); ++kind) {
    out += fmt::format("<g data-curve='{}' fill='{}'>\n", escaped(plot.kinds[kind]), paint_of(kind, frame));
    for (const Tile& tile : plot.tiles) {
      if (tile.kind != kind) continue;
      const double from = left + x.at(tile.x_low) * (width - left - right),
                   to = left + x.at(tile.x_high) * (width - left - right),
                   high = top + (1 - y.at(tile.y_high)) * plot_height,
                   low = top + (1 - y.at(tile.y_low)) * plot_height;
      out += closed(fmt::format("<rect class='tile' x='{:.2f}' y='{:.2f}' width='{:.2f}' height='{:.2f}'",
                                from, high, to - from, low - high),
                    "rect", tile.tip);
    }
    out += "</g>\n";
  }
}

// Draws names beside samples of their lines or fills, in rows above the frame. Returns the height of the
// rows.
double draw_legend(std::string& out, const Plot& plot, double top, std::size_t frame) {
  double u = left, v = top;
  const auto place = [&](const std::string& name, double sample) {
    const double wide = sample + character * static_cast<double>(letters(name)) + 18;
    if (u + wide > width - right + 18 && u > left) u = left, v += 19;
    return wide;
  };
  for (std::size_t kind = 0; kind < plot.kinds.size(); ++kind) {
    if (std::none_of(plot.tiles.begin(), plot.tiles.end(), [&](const Tile& t) { return t.kind == kind; }))
      continue;
    const double wide = place(plot.kinds[kind], 24);
    out += fmt::format(
        "<g data-names='{0}'><rect class='sample' x='{1:.2f}' y='{2:.2f}' width='18' height='11' fill='{3}'/>"
        "<text x='{4:.2f}' y='{5:.2f}'>{0}</text></g>\n",
        escaped(plot.kinds[kind]), u, v - 10, paint_of(kind, frame), u + 24, v);
    u += wide;
  }
  const std::vector<CurveStyle> styles = curve_styles(plot);
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    const Curve& curve = plot.curves[i];
    if (curve.faint) continue;
    const double wide = place(curve.name, 34);
    out += fmt::format(
        "<g data-names='{}'><path class='{}' stroke='{}' stroke-dasharray='{}' d='M{:.2f} {:.2f}h28'/>\n",
        escaped(curve.name), curve.broad ? "broad" : "curve", styles[i].colour, styles[i].dash, u, v - 4);
    if (curve.marks) out += mark(u + 14, v - 4, styles[i], false) + "/>\n";
    out += fmt::format("<text x='{:.2f}' y='{:.2f}'>{}</text></g>\n", u + 34, v, escaped(curve.name));
    u += wide;
  }
  return u == left ? 0 : v - top + 19;
}

// Wraps a sentence at blanks into lines of at most `most` characters.
std::vector<std::string> wrapped(std::string_view sentence, std::size_t most) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t begin = 0; begin < sentence.size();) {
    const std::size_t end = std::min(sentence.find(' ', begin), sentence.size());
    std::string_view word = sentence.substr(begin, end - begin);
    for (; letters(word) > most; word.remove_prefix(most)) {  // e.g. a file's name
      if (!line.empty()) lines.push_back(std::exchange(line, {}));
      lines.emplace_back(word.substr(0, most));
    }
    if (!line.empty() && letters(line) + 1 + letters(word) > most) lines.push_back(std::exchange(line, {}));
    if (!line.empty()) line += ' ';
    line += word;
    begin = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

// "1 dop853, 2 rk4": the faint curves that have a number.
std::string numbered_curves(const Plot& plot) {
  std::string listed;
  for (const Curve& curve : plot.curves)
    if (curve.number > 0)
      listed += fmt::format("{}{} {}", listed.empty() ? "" : ", ", curve.number, curve.name);
  return listed;
}

bool share_x(const std::vector<Curve>& curves) {
  return std::all_of(curves.begin(), curves.end(), [&](const Curve& c) { return c.x == curves.front().x; });
}

}  // namespace

std::string svg(const Plot& plot) {
  std::string body, legend;
  // a unique id, since several plots may be on one page
  const std::size_t frame = std::hash<std::string>()(plot.title + plot.x.label + plot.y.label);
  const std::vector<std::string> title = wrapped(plot.title, 72);
  const double below_title = 18 * (std::max(1., double(title.size())) - 1);
  const double top = 36 + below_title + draw_legend(legend, plot, 48 + below_title, frame) + 4;
  // keep marks away from the frame
  const bool marks =
      std::any_of(plot.curves.begin(), plot.curves.end(), [](const Curve& c) { return c.marks; });
  const PlotScale x = scale_of(plot.x, plot.curves, &Curve::x, 8, marks ? 0.02 : 0),
                  y = scale_of(plot.y, plot.curves, &Curve::y, 6, 0.03);
  if (!plot.tiles.empty()) body += patterns(frame);
  draw_tiles(body, plot, x, y, top, frame);
  draw_axes(body, plot, x, y, top);
  body +=
      fmt::format("<clipPath id='frame{:x}'><rect x='{}' y='{:.2f}' width='{}' height='{}'/></clipPath>\n",
                  frame, left, top, width - left - right, plot_height);
  body += fmt::format("<g clip-path='url(#frame{:x})'>\n", frame);
  const std::vector<CurveStyle> styles = curve_styles(plot);
  for (std::size_t i = 0; i < plot.curves.size(); ++i)
    if (plot.curves[i].faint || plot.curves[i].broad) draw_curve(body, plot.curves[i], styles[i], x, y, top);
  for (const Curve& curve : plot.curves)
    if (!plot.tiles.empty()) draw_halo(body, curve, x, y, top);
  for (std::size_t i = 0; i < plot.curves.size(); ++i)
    if (!plot.curves[i].faint && !plot.curves[i].broad)
      draw_curve(body, plot.curves[i], styles[i], x, y, top);
  draw_numbers(body, plot, x, y, top);
  draw_edge(body, plot.edge, x, top);
  body += "</g>\n";

  double below = top + plot_height + 62;
  std::vector<std::string> notes = plot.notes;
  if (std::string listed = numbered_curves(plot); !listed.empty())
    notes.push_back("Grey, by number: " + listed + ".");
  for (const std::string& note : notes)
    for (const std::string& line : wrapped(note, 104)) {
      body += fmt::format("<text class='note' x='{}' y='{:.2f}'>{}</text>\n", left, below, escaped(line));
      below += 16;
    }
  const double height = std::ceil(below);
  std::string head;
  for (std::size_t i = 0; i < title.size(); ++i)
    head += fmt::format("<text x='{}' y='{}' font-size='15' font-weight='bold'>{}</text>\n", left,
                        22 + 18 * i, escaped(title[i]));
  return fmt::format(
             "<svg xmlns='http://www.w3.org/2000/svg' width='{0}' height='{1}' viewBox='0 0 {0} {1}' "
             "font-family='Helvetica, Arial, \"DejaVu Sans\", sans-serif' font-size='12'>\n"
             "<style>.grid{{stroke:#ddd;stroke-width:.7;fill:none}} .axis{{stroke:#000;fill:none}} "
             ".frame{{stroke:#000;fill:none}} .curve{{fill:none;stroke-width:1.6;stroke-linejoin:round}} "
             ".faint{{fill:none;stroke-width:.8}} .halo{{fill:none;stroke-width:4.5;stroke-linejoin:round}} "
             ".broad{{fill:none;stroke-width:8;stroke-linejoin:round;stroke-linecap:round}} "
             ".cross{{fill:none;stroke:#000;stroke-width:1.2}} "
             ".hatch{{stroke:#333;stroke-width:.8;fill:none}} "
             ".tile{{shape-rendering:crispEdges}} .sample{{stroke:#888;stroke-width:.6}} "
             "text.note{{font-size:11px;fill:#333}} "
             "text.number{{font-size:9px;fill:#666;paint-order:stroke;stroke:#fff;stroke-width:2px}}</"
             "style>\n"
             "<rect width='{0}' height='{1}' fill='#fff'/>\n",
             width, height) +
         head + legend + body + "</svg>\n";
}

std::string csv(const Plot& plot) {
  std::string out = plain_comment("# " + plot.title) + '\n';
  for (const std::string& note : plot.notes) out += plain_comment("# " + note) + '\n';
  if (plot.curves.empty()) return out;
  if (!share_x(plot.curves)) {
    out += fmt::format("curve,{},{}\n", csv_field(plot.x.label), csv_field(plot.y.label));
    for (const Curve& c : plot.curves)
      for (std::size_t i = 0; i < c.x.size(); ++i)
        out += fmt::format("{},{:.17g},{:.17g}\n", csv_field(c.name), c.x[i], c.y[i]);
    return out;
  }
  out += csv_field(plot.x.label);
  for (const Curve& c : plot.curves) out += ',' + csv_field(c.name);
  out += '\n';
  for (std::size_t i = 0; i < plot.curves.front().x.size(); ++i) {
    out += fmt::format("{:.17g}", plot.curves.front().x[i]);
    for (const Curve& c : plot.curves) out += fmt::format(",{:.17g}", c.y[i]);
    out += '\n';
  }
  return out;
}

}  // namespace borelli
