#include "pipeline/recordings/trc_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "error/printable.hpp"
#include "pipeline/recordings/length_unit.hpp"
#include "pipeline/recordings/text_rows.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr std::size_t most_markers = 10000;
constexpr long most_frame_number = 1'000'000'000'000;

// Rows may end early, so a small file could ask for much memory: beyond `free_bytes`, a byte of the file may
// hold no more than this many of the motion.
constexpr double most_bytes_per_byte = 64, free_bytes = 64 << 20;

class TrcReader {
 public:
  TrcReader(std::string_view text, const std::string& file) : text_(text), rows_(text), file_(file) {}

  Result<TrcFile> read() {
    for (const auto step : {&TrcReader::read_type, &TrcReader::read_settings, &TrcReader::read_names,
                            &TrcReader::read_labels, &TrcReader::check_size, &TrcReader::read_frames})
      if (auto fine = (this->*step)(); !fine) return tl::unexpected(fine.error());
    return std::move(trc_);
  }

 private:
  std::string where() const { return fmt::format("{}:{}", file_, rows_.number()); }
  tl::unexpected<Error> refuse(const std::string& what) const { return bad_use(where(), what); }
  void warn(std::string sentence) { trc_.warnings.push_back(std::move(sentence)); }

  Result<void> read_type() {
    const auto words = rows_.next() ? blank_words(rows_.line()) : std::vector<std::string_view>{};
    if (words.empty() || words[0] != "PathFileType")
      return refuse("does not begin with 'PathFileType', expected a TRC file");
    if (words.size() < 2 || (words[1] != "4" && words[1] != "3"))
      return refuse(fmt::format("is of path file type '{}', expected 3 or 4",
                                words.size() < 2 ? "" : printable(words[1])));
    return {};
  }

  Result<void> read_settings() {
    if (!rows_.next()) return refuse("ends before its line of keys (DataRate, CameraRate, ...)");
    const auto keys = blank_words(rows_.line());
    if (!rows_.next()) return refuse("ends before the values of its header");
    auto values = blank_words(rows_.line());
    const auto value_of = [&](std::string_view key) -> std::string_view {
      const auto at = static_cast<std::size_t>(std::ranges::find(keys, key) - keys.begin());
      return at < std::min(keys.size(), values.size()) ? values[at] : std::string_view();
    };
    if (!per_metre(value_of("Units")))  // a cell between tabs may be empty
      if (const auto cells = tab_cells(rows_.line()); cells.size() <= keys.size()) values = cells;
    for (const auto& [key, rate] :
         {std::pair{"DataRate", &trc_.data_rate}, std::pair{"CameraRate", &trc_.camera_rate}}) {
      const std::string_view given = value_of(key);
      const auto number = given.empty() ? std::optional<double>(0) : finite_number(given);
      if (!number || *number < 0)
        return refuse(fmt::format("{} is '{}', expected a rate in Hz", key, printable(given)));
      *rate = *number;
    }
    for (const auto& [key, count] : {std::pair{"NumFrames", &frames_told_}, {"NumMarkers", &markers_told_}}) {
      const std::string_view given = value_of(key);
      if (given.empty()) continue;
      *count = finite_number(given);  // (some programs write "120.0")
      if (!*count || **count < 0)
        return refuse(fmt::format("{} is '{}', expected a count", key, printable(given)));
    }
    const std::string_view unit = value_of("Units");
    if (unit.empty()) return refuse("has no Units in its header, expected a unit of length");
    if (const auto known = per_metre(unit))
      per_metre_ = *known;
    else
      return refuse(fmt::format("Units is '{}', expected {}", printable(unit), length_units));
    trc_.unit = unit;
    return {};
  }

  Result<void> read_names() {
    if (!rows_.next()) return refuse("ends before its line of marker names");
    std::vector<std::string_view> cells = tab_cells(rows_.line());
    if (rows_.line().find('\t') == std::string_view::npos) cells = blank_words(rows_.line());
    std::erase_if(cells, [](std::string_view cell) { return cell.empty(); });
    if (cells.size() < 2 || lower_case(cells[0]) != "frame#" || lower_case(cells[1]) != "time")
      return refuse("does not begin with Frame# and Time, expected the line of marker names");
    auto& names = trc_.motion.names;
    names.assign(cells.begin() + 2, cells.end());
    names_line_ = rows_.number();
    if (names.empty()) return refuse("names no marker");
    if (names.size() > most_markers)
      return refuse(fmt::format("names {} markers, expected at most {}", names.size(), most_markers));
    std::set<std::string_view> seen;
    for (const std::string& name : names)
      if (!seen.insert(name).second)
        return refuse(fmt::format("names the marker '{}' twice", printable(name)));
    return {};
  }

  Result<void> read_labels() {
    if (!rows_.next()) return refuse("ends before its line of coordinate labels (X1, Y1, Z1, ...)");
    const auto labels = blank_words(rows_.line());
    const std::size_t count = trc_.motion.names.size();
    if (labels.empty() || lower_case(labels[0]).front() != 'x')
      return refuse("does not begin with X1, expected the line of coordinate labels (X1, Y1, Z1, ...)");
    if (labels.size() != 3 * count)
      return refuse(
          fmt::format("has {} coordinate labels, expected {}: three for each of the {} names in line {}",
                      labels.size(), 3 * count, count, names_line_));
    if (markers_told_ && *markers_told_ != static_cast<double>(count))
      warn(fmt::format("The header announces {:g} markers, but {} are named; those were read.",
                       *markers_told_, count));
    return {};
  }

  // Bounds the memory before the rows are read.
  Result<void> check_size() {
    const double lines =
        static_cast<double>(std::ranges::count_if(text_, [](char c) { return c == '\n' || c == '\r'; }));
    const double bytes = (lines + 1) * (24.0 * static_cast<double>(trc_.motion.names.size()) + 24);
    if (bytes > free_bytes && bytes > most_bytes_per_byte * static_cast<double>(text_.size()))
      return bad_use(file_,
                     fmt::format("has up to {:.0f} rows for {} markers in {} bytes, expected rows that "
                                 "do not end so early",
                                 lines, trc_.motion.names.size(), text_.size()));
    return admit_memory(file_, "its motion", bytes);
  }

  Result<void> read_frames() {
    while (rows_.next()) {
      if (rows_.is_blank()) continue;
      if (auto fine = read_frame(); !fine) return fine;
    }
    const std::size_t count = trc_.motion.frames.size();
    if (count == 0) return bad_use(file_, "holds no frame after its header");
    if (frames_told_ && *frames_told_ != static_cast<double>(count))
      warn(fmt::format("The header announces {:g} frames, but the file contains {}; those were read.",
                       *frames_told_, count));
    if (partly_seen_ > 0)
      warn(fmt::format(
          "A marker lacks one or two of its coordinates {} times; it was read as not seen in these frames.",
          partly_seen_));
    return {};
  }

  Result<void> read_frame() {
    MarkerMotion& motion = trc_.motion;
    const bool tabs = rows_.line().find('\t') != std::string_view::npos;
    const auto cells = tabs ? tab_cells(rows_.line()) : blank_words(rows_.line());
    const std::size_t columns = 3 * motion.names.size() + 2;
    if (cells.size() > columns)
      return refuse(fmt::format("has {} cells, expected at most {} for {} markers", cells.size(), columns,
                                motion.names.size()));
    const auto number = integer_number(cells[0]);
    if (!number) return refuse(fmt::format("begins with '{}', expected a frame number", printable(cells[0])));
    const auto time = cells.size() > 1 ? finite_number(cells[1]) : std::nullopt;
    if (!time)
      return refuse(fmt::format("has the time '{}', expected a number of seconds",
                                cells.size() > 1 ? printable(cells[1]) : ""));
    if (motion.times.empty())
      trc_.first_frame = *number;
    else if (!(*time > motion.times.back()))
      return refuse(fmt::format("has the time {} s, expected more than the {} s of the row before",
                                exact(*time), exact(motion.times.back())));
    auto places = read_places(cells);
    if (!places) return tl::unexpected(places.error());
    motion.times.push_back(*time);
    motion.frames.push_back(std::move(*places));
    return {};
  }

  Result<Eigen::Matrix3Xd> read_places(const std::vector<std::string_view>& cells) {
    const auto& names = trc_.motion.names;
    Eigen::Matrix3Xd places =
        Eigen::Matrix3Xd::Constant(3, std::ssize(names), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t marker = 0; marker < names.size() && 3 * marker + 2 < cells.size(); ++marker) {
      Eigen::Vector3d place;
      int seen = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t at = 3 * marker + 2 + axis;
        if (at >= cells.size() || is_gap(cells[at])) continue;
        const auto coordinate = finite_number(cells[at]);
        if (!coordinate)
          return refuse(
              fmt::format("{} of marker '{}' is '{}', expected a number with a decimal point, or "
                          "nothing",
                          "XYZ"[axis], printable(names[marker]), printable(cells[at])));
        place[static_cast<Eigen::Index>(axis)] = *coordinate / per_metre_;
        ++seen;
      }
      if (seen == 3) places.col(static_cast<Eigen::Index>(marker)) = place;
      if (seen == 1 || seen == 2) ++partly_seen_;
    }
    return places;
  }

  std::string_view text_;
  TextRows rows_;
  std::string file_;
  TrcFile trc_;
  double per_metre_ = 1000;
  std::optional<double> frames_told_, markers_told_;
  int names_line_ = 0, partly_seen_ = 0;
};

Result<void> check_marker_motion(const MarkerMotion& motion, const std::string& name) {
  if (motion.names.empty() || motion.frames.empty() || motion.frames.size() != motion.times.size())
    return failure(name, fmt::format("cannot be written with {} markers, {} frames and {} times",
                                     motion.names.size(), motion.frames.size(), motion.times.size()));
  std::set<std::string_view> seen;
  for (const std::string& marker : motion.names)
    if (trimmed(marker) != marker || marker.empty() || marker.find_first_of("\t\r\n\v\f") != marker.npos ||
        !seen.insert(marker).second)
      return failure(name, fmt::format("cannot be written: the marker name '{}' is empty, doubled, or holds "
                                       "tabs, line ends or blanks around it",
                                       printable(marker)));
  for (std::size_t i = 0; i < motion.times.size(); ++i) {
    if (motion.frames[i].cols() != std::ssize(motion.names))
      return failure(name, fmt::format("cannot be written: frame {} has {} markers, expected {}", i + 1,
                                       motion.frames[i].cols(), motion.names.size()));
    if (!std::isfinite(motion.times[i]) || (i > 0 && !(motion.times[i] > motion.times[i - 1])))
      return failure(name, fmt::format("cannot be written: the time of frame {} does not rise", i + 1));
  }
  return {};
}

}  // namespace

Result<TrcFile> parse_trc(std::string_view text, const std::string& file) {
  return TrcReader(text, file).read();
}

Result<TrcFile> read_trc(const std::filesystem::path& path) {
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  return parse_trc(*text, path.string());
}

namespace {

// One over the mean interval without gaps and short ones, Hz. (Times may be rounded.) 1 for a single frame.
double usual_rate(const std::vector<double>& times) {
  if (times.size() < 2) return 1;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  double sum = 0, count = 0;
  for (const double interval : intervals)
    if (interval > *middle / 2 && interval < 1.5 * *middle) sum += interval, ++count;
  return std::round(1e6 * count / sum) / 1e6;
}

}  // namespace

Result<std::string> trc_text(const TrcFile& trc, const std::string& name) {
  const MarkerMotion& motion = trc.motion;
  if (auto fine = check_marker_motion(motion, name); !fine) return tl::unexpected(fine.error());
  const auto units = per_metre(trc.unit);
  if (!units)
    return bad_use(name,
                   fmt::format("cannot be written in '{}', expected {}", printable(trc.unit), length_units));
  const std::size_t frames = motion.frames.size();
  const std::string rate = decimal_text(trc.data_rate > 0 ? trc.data_rate : usual_rate(motion.times));
  std::string out = fmt::format(
      "PathFileType\t4\t(X/Y/Z)\t{}\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
      "OrigDataStartFrame\tOrigNumFrames\n{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\nFrame#\tTime",
      printable(std::filesystem::path(name).filename().string(), 200), rate,
      trc.camera_rate > 0 ? decimal_text(trc.camera_rate) : rate, frames, motion.names.size(),
      std::string(trimmed(trc.unit)), rate, trc.first_frame, frames);
  for (const std::string& marker : motion.names) out += "\t" + marker + "\t\t";
  out += "\n\t";
  for (std::size_t i = 1; i <= motion.names.size(); ++i) out += fmt::format("\tX{0}\tY{0}\tZ{0}", i);
  out += "\n\n";
  for (std::size_t i = 0; i < frames; ++i) {
    out += fmt::format("{}\t{}", trc.first_frame + static_cast<long>(i), exact(motion.times[i]));
    for (const double coordinate : motion.frames[i].reshaped())
      out += "\t" + decimal_text(coordinate * *units);
    out += '\n';
  }
  return out;
}

}  // namespace borelli
