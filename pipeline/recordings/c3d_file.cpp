#include "pipeline/recordings/c3d_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "error/printable.hpp"
#include "pipeline/recordings/c3d_events.hpp"
#include "pipeline/recordings/c3d_layout.hpp"
#include "pipeline/recordings/c3d_plates.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

struct PointPlace {
  bool output = false;  // of `C3dFile::outputs`; else a marker
  Index index = 0;
};

// Names in order: blanks become `point_7`, a repeated `A` becomes `A_2`.
std::vector<std::string> unique_c3d_names(const std::vector<std::string>& labels, std::uint64_t count,
                                          const std::string& what, std::vector<std::string>& warnings) {
  std::vector<std::string> out;
  std::set<std::string> taken;
  std::map<std::string, int> repeats;
  int repeated = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string label =
        i < labels.size() && !labels[i].empty() ? labels[i] : fmt::format("{}_{}", what, i + 1);
    std::string name = label;
    for (int& number = repeats[label]; !taken.insert(name).second;)
      name = fmt::format("{}_{}", label, number = std::max(number + 1, 2));
    if (name != label) ++repeated;
    out.push_back(std::move(name));
  }
  if (labels.size() < count)
    warnings.push_back(fmt::format("{} of {} {}s have no label", count - labels.size(), count, what));
  if (repeated > 0) warnings.push_back(fmt::format("{} of {} {}s repeat a label", repeated, count, what));
  return out;
}

// The kinds of the points that are no markers, by their labels.
std::map<std::string, std::string> kinds_of_outputs(const C3dParameters& parameters) {
  const std::vector<std::string> pairs = parameters.texts("POINT", "TYPE_GROUPS");
  std::vector<std::pair<std::string, std::string>> groups;
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) groups.emplace_back(pairs[i], pairs[i + 1]);
  for (const std::string kind : {"ANGLE", "FORCE", "MOMENT", "POWER", "SCALAR", "REACTION"})
    groups.emplace_back(kind + "S", kind);
  std::map<std::string, std::string> out;
  for (const auto& [group, kind] : groups)
    if (group != "MODELED_MARKERS" && group != "LABELS" && group != "DESCRIPTIONS")
      for (const std::string& label : parameters.texts("POINT", group))
        if (!label.empty()) out.emplace(label, kind);
  return out;
}

// Four characters hold `mete` of metres, so the beginning of a unit decides.
std::optional<double> metres_of_point_unit(const std::string& unit) {
  static const std::pair<std::string_view, double> known[] = {
      {"mm", 0.001}, {"mill", 0.001}, {"cm", 0.01},   {"cent", 0.01},   {"dm", 0.1},     {"deci", 0.1},
      {"met", 1},    {"in", 0.0254},  {"ft", 0.3048}, {"foot", 0.3048}, {"feet", 0.3048}};
  std::string name;
  for (const char c : unit) name += static_cast<char>(c >= 'A' && c <= 'Z' ? c | 0x20 : c);
  if (name == "m") return 1;
  for (const auto& [beginning, metres] : known)
    if (name.starts_with(beginning)) return metres;
  return std::nullopt;
}

class C3dReader {
 public:
  C3dReader(const std::string& bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  Result<C3dFile> read() {
    if (auto checked = read_sections(); !checked) return tl::unexpected(checked.error());
    if (auto known = read_unit(); !known) return tl::unexpected(known.error());
    name_points();
    name_channels();
    read_frames();
    out_.subjects = parameters_.texts("SUBJECTS", "NAMES");
    out_.events = c3d_events(bytes_, processor_, parameters_, layout_, out_.warnings);
    read_forces();
    return std::move(out_);
  }

 private:
  // the key, the processor, the parameters, the layout
  Result<void> read_sections() {
    if (bytes_.size() < 512)
      return failure(file_, fmt::format("has {} bytes, too few for a C3D file", bytes_.size()));
    if (bytes_[1] != 0x50)
      return failure(file_, fmt::format("is not a C3D file: its second byte is {}, expected 80",
                                        static_cast<std::uint8_t>(bytes_[1])));
    const std::size_t block = static_cast<std::uint8_t>(bytes_[0]);
    const std::size_t start = 512 * (std::max<std::size_t>(block, 1) - 1);
    if (block < 2 || start + 4 > bytes_.size())
      return failure(
          file_, fmt::format("has its parameters in block {}, but only {} blocks; it is cut off or damaged",
                             block, bytes_.size() / 512));
    const auto processor = c3d_processor(static_cast<std::uint8_t>(bytes_[start + 3]));
    if (!processor)
      return failure(file_, fmt::format("names processor {}, expected 84 (Intel), 85 (DEC) or 86 (MIPS)",
                                        static_cast<std::uint8_t>(bytes_[start + 3])));
    processor_ = *processor;
    // Vicon 370 counts one block, whatever it writes: the data then end the section.
    const std::size_t blocks = static_cast<std::uint8_t>(bytes_[start + 2]);
    const std::size_t data = 512 * std::size_t{c3d_word(bytes_.data() + 16, processor_)};
    const std::size_t end =
        std::max(start + 512 * std::max<std::size_t>(blocks, 1), data < 512 ? 0 : data - 512);
    auto parameters = read_c3d_parameters(bytes_, start, end, processor_, file_, out_.warnings);
    if (!parameters) return tl::unexpected(parameters.error());
    parameters_ = std::move(*parameters);
    const auto layout = c3d_layout(bytes_, processor_, parameters_, file_, out_.warnings);
    if (!layout) return tl::unexpected(layout.error());
    layout_ = *layout;
    return {};
  }

  Result<void> read_unit() {
    const std::string unit = parameters_.line("POINT", "UNITS");
    const auto metres = metres_of_point_unit(unit);
    if (!metres && !unit.empty() && layout_.points != 0)
      return failure(file_,
                     fmt::format("has POINT:UNITS '{}', expected mm, cm, dm, m, in or ft", printable(unit)));
    if (!metres && layout_.points != 0)
      out_.warnings.push_back("POINT:UNITS is missing; lengths were read as mm");
    metres_ = metres.value_or(0.001);
    return {};
  }

  void name_points() {
    const std::map<std::string, std::string> kinds = kinds_of_outputs(parameters_);
    std::vector<std::string> labels = parameters_.texts("POINT", "LABELS");
    std::vector<std::string> kind_of(labels.size());
    for (std::size_t i = 0; i < labels.size(); ++i)
      if (const auto kind = kinds.find(labels[i]); kind != kinds.end()) kind_of[i] = kind->second;
    const std::vector<std::string> subjects = parameters_.texts("SUBJECTS", "NAMES");
    if (subjects.size() == 1 && !subjects[0].empty())
      for (std::string& label : labels)
        if (label.starts_with(subjects[0] + ":")) label = label.substr(subjects[0].size() + 1);
    const auto frames = static_cast<Index>(layout_.frames);
    for (const std::string& name : unique_c3d_names(labels, layout_.points, "point", out_.warnings)) {
      const std::size_t i = places_.size();
      if (i < kind_of.size() && !kind_of[i].empty()) {
        places_.push_back({true, static_cast<Index>(out_.outputs.size())});
        out_.outputs.push_back({name, kind_of[i], parameters_.line("POINT", kind_of[i] + "_UNITS"),
                                Eigen::Matrix3Xd(3, frames)});
      } else {
        places_.push_back({false, static_cast<Index>(out_.markers.names.size())});
        out_.markers.names.push_back(name);
      }
    }
    const auto markers = static_cast<Index>(out_.markers.names.size());
    out_.markers.frames.assign(layout_.frames, Eigen::Matrix3Xd(3, markers));
    out_.residuals.resize(markers, frames);
    for (Index i = 0; i < frames; ++i)
      out_.markers.times.push_back((layout_.first_frame - 1 + static_cast<double>(i)) / layout_.rate);
  }

  void name_channels() {
    const std::vector<std::string> units = parameters_.texts("ANALOG", "UNITS");
    const std::vector<std::string> descriptions = parameters_.texts("ANALOG", "DESCRIPTIONS");
    const auto samples = static_cast<Index>(layout_.frames * layout_.samples);
    for (std::string& name : unique_c3d_names(parameters_.texts("ANALOG", "LABELS"), layout_.channels,
                                              "channel", out_.warnings)) {
      const std::size_t i = out_.analog.size();
      out_.analog.push_back({std::move(name), i < descriptions.size() ? descriptions[i] : "",
                             i < units.size() ? units[i] : "", Eigen::VectorXd(samples)});
    }
    if (layout_.channels == 0) return;
    const double step = 1 / (layout_.rate * static_cast<double>(layout_.samples));
    const double first = (layout_.first_frame - 1) * static_cast<double>(layout_.samples);
    for (Index i = 0; i < samples; ++i) out_.analog_times.push_back((first + static_cast<double>(i)) * step);
  }

  double number_at(std::uint64_t at) const {
    return layout_.real ? static_cast<double>(c3d_real(bytes_.data() + at, processor_))
                        : static_cast<double>(c3d_integer(bytes_.data() + at, processor_));
  }

  void read_point(std::uint64_t at, Index frame, const PointPlace& place) {
    const std::uint64_t step = layout_.number_bytes();
    Vector3d p(number_at(at), number_at(at + step), number_at(at + 2 * step));
    if (!layout_.real) p *= layout_.scale;
    // Word 4 is negative in a gap; else its low byte is the residual, its high byte a mask of the cameras.
    const double word = number_at(at + 3 * step);
    const bool measured = word >= 0 && word <= 65535;
    const int residual = measured ? static_cast<int>(word) & 0xff : 0;
    const bool unfilled = !place.output && p.isZero(0) && word == 0;
    if (!measured || !p.allFinite() || unfilled) p.setConstant(std::numeric_limits<double>::quiet_NaN());
    if (place.output) {
      out_.outputs[static_cast<std::size_t>(place.index)].values.col(frame) = p;
      return;
    }
    out_.markers.frames[static_cast<std::size_t>(frame)].col(place.index) = p * metres_;
    out_.residuals(place.index, frame) = std::isfinite(p.x()) ? residual * layout_.scale * metres_ : p.x();
  }

  struct AnalogScale {
    double offset, scale;
  };

  std::vector<AnalogScale> analog_scales() {
    const std::vector<double> offsets = parameters_.numbers("ANALOG", "OFFSET");
    const std::vector<double> scales = parameters_.numbers("ANALOG", "SCALE");
    const double general = parameters_.number("ANALOG", "GEN_SCALE").value_or(1);
    std::vector<AnalogScale> out;
    for (std::size_t i = 0; i < layout_.channels; ++i) {
      const double offset = i < offsets.size() ? offsets[i] : 0;
      out.push_back(
          {unsigned_ && offset < 0 ? offset + 65536 : offset, general * (i < scales.size() ? scales[i] : 1)});
    }
    if (scales.size() < layout_.channels)
      out_.warnings.push_back(fmt::format("{} of {} analog channels have no ANALOG:SCALE; 1 was used",
                                          layout_.channels - scales.size(), layout_.channels));
    return out;
  }

  void read_frames() {
    unsigned_ = parameters_.line("ANALOG", "FORMAT") == "UNSIGNED";
    const std::vector<AnalogScale> scales = analog_scales();
    const std::uint64_t step = layout_.number_bytes();
    std::uint64_t at = layout_.data;
    for (std::uint64_t frame = 0; frame < layout_.frames; ++frame) {
      for (std::size_t i = 0; i < layout_.points; ++i, at += 4 * step)
        read_point(at, static_cast<Index>(frame), places_[i]);
      for (std::uint64_t sample = 0; sample < layout_.samples; ++sample)
        for (std::size_t i = 0; i < layout_.channels; ++i, at += step) {
          double number = number_at(at);
          if (unsigned_ && !layout_.real && number < 0) number += 65536;
          out_.analog[i].values[static_cast<Index>(frame * layout_.samples + sample)] =
              (number - scales[i].offset) * scales[i].scale;
        }
    }
  }

  // A signed axis of the file: "+Z", "-Y", "Z".
  static std::optional<Vector3d> axis(const std::string& text) {
    const bool negative = text.starts_with('-');
    const std::string letter = text.starts_with('-') || text.starts_with('+') ? text.substr(1) : text;
    if (letter.size() != 1) return std::nullopt;
    const auto index = std::string_view("XYZxyz").find(letter[0]);
    if (index == std::string_view::npos) return std::nullopt;
    return negative ? -Vector3d::Unit(static_cast<Index>(index % 3))
                    : Vector3d(Vector3d::Unit(static_cast<Index>(index % 3)));
  }

  Vector3d mean_marker() const {
    Vector3d sum = Vector3d::Zero();
    double count = 0;
    for (const Eigen::Matrix3Xd& frame : out_.markers.frames)
      for (Index i = 0; i < frame.cols(); ++i)
        if (frame.col(i).allFinite()) sum += frame.col(i), ++count;
    return sum / count;  // NaN without markers
  }

  void find_up(const std::vector<ForcePlate>& plates) {
    std::optional<Vector3d> up = axis(parameters_.line("POINT", "Y_SCREEN"));
    if (plates.empty()) {
      out_.markers.up = up;
      return;
    }
    Vector3d centre = Vector3d::Zero(), normal = Vector3d::Zero();
    for (const ForcePlate& plate : plates) {
      centre += plate.corners.rowwise().mean() / static_cast<double>(plates.size());
      normal += plate_normal(plate_axes(plate).value(), up) / static_cast<double>(plates.size());
    }
    if (up && (mean_marker() - centre).dot(*up) < 0) {
      out_.warnings.push_back(
          "by POINT:Y_SCREEN the markers lie below the force plates, so the upward axis was reversed");
      up = -*up;
    }
    Index nearest = 0;
    if (const double most = normal.cwiseAbs().maxCoeff(&nearest); !up && most > std::cos(5 * M_PI / 180))
      up = normal[nearest] > 0 ? Vector3d(Vector3d::Unit(nearest)) : Vector3d(-Vector3d::Unit(nearest));
    out_.markers.up = up;
  }

  void read_forces() {
    const std::vector<ForcePlate> plates =
        c3d_plates(parameters_, layout_, out_.analog, metres_, out_.warnings);
    find_up(plates);
    for (const ForcePlate& plate : plates)
      if (auto force = measured_force(plate, out_.analog_times, out_.markers.up, out_.warnings))
        out_.forces.push_back(std::move(*force));
  }

  const std::string& bytes_;
  const std::string& file_;
  C3dProcessor processor_ = C3dProcessor::intel;
  C3dParameters parameters_;
  C3dLayout layout_;
  double metres_ = 0.001;
  bool unsigned_ = false;
  std::vector<PointPlace> places_;
  C3dFile out_;
};

}  // namespace

Result<C3dFile> read_c3d(const std::filesystem::path& path) {
  const auto bytes = read_input_file(path, any_size);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string file = path.string();
  return C3dReader(*bytes, file).read();
}

}  // namespace borelli
