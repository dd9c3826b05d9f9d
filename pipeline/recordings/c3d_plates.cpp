#include "pipeline/recordings/c3d_plates.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <set>

namespace borelli {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

std::string letters_of(const std::string& unit) {
  std::string out;
  for (const char c : unit)
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z')) out += static_cast<char>(c | 0x20);
  return out;
}

double newtons(const std::string& unit) { return letters_of(unit) == "kn" ? 1000 : 1; }

double newton_metres(const std::string& unit, double metres) {
  const std::string name = letters_of(unit);
  if (name == "nm" || name == "ntm") return 1;
  if (name == "ncm" || name == "ntcm") return 0.01;
  if (name == "nmm" || name == "ntmm") return 0.001;
  return metres;
}

double metres_of_position(const std::string& unit, double metres) {
  const std::string name = letters_of(unit);
  return name == "m" ? 1 : name == "cm" ? 0.01 : name == "mm" ? 0.001 : metres;
}

class C3dPlateReader {
 public:
  C3dPlateReader(const C3dParameters& parameters, const C3dLayout& layout,
                 const std::vector<AnalogChannel>& analog, double metres, std::vector<std::string>& warnings)
      : analog_(analog),
        metres_(metres),
        warnings_(warnings),
        types_(parameters.numbers("FORCE_PLATFORM", "TYPE")),
        corners_(parameters.numbers("FORCE_PLATFORM", "CORNERS")),
        origins_(parameters.numbers("FORCE_PLATFORM", "ORIGIN")),
        matrices_(parameters.numbers("FORCE_PLATFORM", "CAL_MATRIX")),
        channels_(parameters.numbers("FORCE_PLATFORM", "CHANNEL")),
        unloaded_(unloaded_samples(parameters, layout)) {
    if (const C3dParameter* channel = parameters.find("FORCE_PLATFORM", "CHANNEL"))
      if (!channel->dimensions.empty()) stride_ = static_cast<std::size_t>(channel->dimensions[0]);
    if (const C3dParameter* matrix = parameters.find("FORCE_PLATFORM", "CAL_MATRIX"))
      six_by_six_ =
          matrix->dimensions.size() >= 2 && matrix->dimensions[0] == 6 && matrix->dimensions[1] == 6;
  }

  std::optional<ForcePlate> plate(std::size_t i) {
    ForcePlate out;
    out.name = fmt::format("force plate {}", i + 1);
    if (i >= types_.size()) return left_out(out.name, "has no entry in FORCE_PLATFORM:TYPE");
    if (!(types_[i] >= 1 && types_[i] <= 4))
      return left_out(out.name, fmt::format("is of type {:g}, and only types 1 to 4 are read", types_[i]));
    out.type = static_cast<int>(types_[i]);
    if (corners_.size() < 12 * (i + 1)) return left_out(out.name, "has no FORCE_PLATFORM:CORNERS");
    for (std::size_t k = 0; k < 12; ++k)
      out.corners(static_cast<Index>(k % 3), static_cast<Index>(k / 3)) = corners_[12 * i + k] * metres_;
    if (origins_.size() >= 3 * (i + 1))
      out.origin = Vector3d(origins_[3 * i], origins_[3 * i + 1], origins_[3 * i + 2]) * metres_;
    else if (out.type == 3)
      return left_out(out.name, "has no FORCE_PLATFORM:ORIGIN");
    else if (out.type != 1)
      warnings_.push_back(fmt::format(
          "{} has no FORCE_PLATFORM:ORIGIN, so its moments were taken about a point of the surface",
          out.name));
    if (!out.origin.allFinite()) return left_out(out.name, "has an ORIGIN that is not finite");
    if (const auto axes = plate_axes(out); !axes) return left_out(out.name, axes.error().what);
    if (!read_channels(out, i)) return std::nullopt;
    out.unloaded = unloaded_;
    return out;
  }

 private:
  std::nullopt_t left_out(const std::string& name, const std::string& why) {
    warnings_.push_back(fmt::format("{} {}: it is left out", name, why));
    return std::nullopt;
  }

  // ZERO holds the first and the last frame, counted from 1; frame 0 stands for 1, and 0 0 and 1 0 for none.
  static std::pair<Index, Index> unloaded_samples(const C3dParameters& parameters, const C3dLayout& layout) {
    const std::vector<double> zero = parameters.numbers("FORCE_PLATFORM", "ZERO");
    if (zero.size() < 2 || !(zero[0] >= 0) || !(zero[1] >= std::max(zero[0], 1.0))) return {0, 0};
    if (!(zero[1] <= static_cast<double>(layout.frames))) return {0, 0};
    const auto samples = static_cast<Index>(layout.samples);
    return {(static_cast<Index>(std::max(zero[0], 1.0)) - 1) * samples,
            static_cast<Index>(zero[1]) * samples};
  }

  bool read_channels(ForcePlate& plate, std::size_t i) {
    const std::size_t rows = plate.type == 3 ? 8 : 6;
    if (stride_ < rows || channels_.size() < stride_ * i + rows)
      return left_out(plate.name, fmt::format("has no {} channels in FORCE_PLATFORM:CHANNEL", rows)), false;
    std::vector<const AnalogChannel*> rows_of;
    for (std::size_t row = 0; row < rows; ++row) {
      const double number = channels_[stride_ * i + row];
      if (!(number >= 1 && number <= static_cast<double>(analog_.size())))
        return left_out(plate.name, fmt::format("names analog channel {:g} of {}", number, analog_.size())),
               false;
      if (!taken_.insert(number).second)
        return left_out(plate.name, fmt::format("names analog channel {:g}, which is taken", number)), false;
      rows_of.push_back(&analog_[static_cast<std::size_t>(number) - 1]);
    }
    plate.channels.resize(static_cast<Index>(rows), rows_of[0]->values.size());
    for (std::size_t row = 0; row < rows; ++row)
      plate.channels.row(static_cast<Index>(row)) = rows_of[row]->values;
    if (plate.type == 4 && !matrices_.empty()) return calibrate(plate, i);
    if (plate.type == 4) {
      if (letters_of(rows_of[2]->unit) == "v") return left_out(plate.name, "has no CAL_MATRIX"), false;
      warnings_.push_back(
          fmt::format("{} has no CAL_MATRIX, so its channels were not calibrated", plate.name));
    }
    for (std::size_t row = 0; row < rows; ++row) {
      const std::string& unit = rows_of[row]->unit;
      const bool force = row < 3 || plate.type == 3, position = plate.type == 1 && row < 5;
      plate.channels.row(static_cast<Index>(row)) *= force      ? newtons(unit)
                                                     : position ? metres_of_position(unit, metres_)
                                                                : newton_metres(unit, metres_);
    }
    return true;
  }

  bool calibrate(ForcePlate& plate, std::size_t i) {
    if (!six_by_six_ || matrices_.size() < 36 * (i + 1))
      return left_out(plate.name, "has no matrix of 6 by 6 in CAL_MATRIX"), false;
    const Eigen::Matrix<double, 6, 6> matrix(matrices_.data() + 36 * i);
    if (!matrix.allFinite() || matrix.isZero()) return left_out(plate.name, "has an empty CAL_MATRIX"), false;
    plate.channels = (matrix * plate.channels).eval();
    plate.channels.bottomRows(3) *= metres_;
    return true;
  }

  const std::vector<AnalogChannel>& analog_;
  double metres_;
  std::vector<std::string>& warnings_;
  std::vector<double> types_, corners_, origins_, matrices_, channels_;
  std::pair<Index, Index> unloaded_;
  std::size_t stride_ = 0;
  bool six_by_six_ = false;
  std::set<double> taken_;  // a channel belongs to one plate: this bounds memory by the file's size
};

}  // namespace

std::vector<ForcePlate> c3d_plates(const C3dParameters& parameters, const C3dLayout& layout,
                                   const std::vector<AnalogChannel>& analog, double metres,
                                   std::vector<std::string>& warnings) {
  std::vector<ForcePlate> out;
  const double used = parameters.count("FORCE_PLATFORM", "USED").value_or(0);
  if (used == 0) return out;
  C3dPlateReader reader(parameters, layout, analog, metres, warnings);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::min(used, 255.0)); ++i) {
    if (auto plate = reader.plate(i)) out.push_back(std::move(*plate));
  }
  return out;
}

}  // namespace borelli
