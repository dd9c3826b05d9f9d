#include "pipeline/recordings/c3d_layout.hpp"

#include <fmt/core.h>

#include <cmath>

namespace borelli {
namespace {

constexpr std::uint64_t c3d_block = 512;

// Words of the header, counted from 1 as the user guide does.
struct C3dHeader {
  C3dHeader(const char* bytes, C3dProcessor processor)
      : points(word(bytes, 2, processor)),
        analog_numbers(word(bytes, 3, processor)),
        first_frame(word(bytes, 4, processor)),
        last_frame(word(bytes, 5, processor)),
        data_block(word(bytes, 9, processor)),
        samples(word(bytes, 10, processor)),
        scale(c3d_real(bytes + 12, processor)),
        rate(c3d_real(bytes + 20, processor)) {}

  static std::uint16_t word(const char* bytes, int number, C3dProcessor processor) {
    return c3d_word(bytes + 2 * (number - 1), processor);
  }

  std::uint64_t points, analog_numbers, first_frame, last_frame, data_block, samples;
  double scale, rate;
};

bool is_scale(double scale) { return std::isfinite(scale) && scale != 0; }
bool is_rate(double rate) { return std::isfinite(rate) && rate > 0; }

// A count that parameters may give as a real: up to 2^40, what no file holds and no product overflows.
std::uint64_t bounded_count(double count) {
  return static_cast<std::uint64_t>(std::min(count, std::ldexp(1.0, 40)));
}

// A 32-bit number in two words, the low one first.
std::optional<double> trial_field(const C3dParameters& parameters, std::string_view name) {
  const C3dParameter* field = parameters.find("TRIAL", name);
  if (field == nullptr || field->numbers.size() < 2) return std::nullopt;
  const auto word = [&](std::size_t i) {
    return field->numbers[i] < 0 ? field->numbers[i] + 65536 : field->numbers[i];
  };
  return word(0) + 65536 * word(1);
}

std::optional<double> trial_frames(const C3dParameters& parameters) {
  const auto first = trial_field(parameters, "ACTUAL_START_FIELD");
  const auto last = trial_field(parameters, "ACTUAL_END_FIELD");
  if (!first || !last || !(*last >= *first)) return std::nullopt;
  return *last - *first + 1;
}

std::uint64_t header_frames(const C3dHeader& header) {
  return header.last_frame < header.first_frame ? 0 : header.last_frame - header.first_frame + 1;
}

std::uint64_t parameter_frames(const C3dHeader& header, const C3dParameters& parameters) {
  const auto frames = parameters.count("POINT", "FRAMES");
  const auto trial = trial_frames(parameters);
  const bool wrapped = frames && trial && *trial > *frames && std::fmod(*trial - *frames, 65536) == 0;
  if (frames && *frames != 65535 && !wrapped) return bounded_count(*frames);
  if (const auto many = parameters.count("POINT", "LONG_FRAMES"); many && *many >= 1)
    return bounded_count(*many);
  if (trial) return bounded_count(*trial);
  return frames ? bounded_count(*frames) : header_frames(header);
}

C3dLayout layout_of_header(const C3dHeader& header) {
  C3dLayout out;
  out.points = header.points;
  out.samples = std::max<std::uint64_t>(header.samples, 1);
  out.channels = header.analog_numbers / out.samples;
  out.frames = header_frames(header);
  out.data = header.data_block * c3d_block - (header.data_block == 0 ? 0 : c3d_block);
  out.real = header.scale < 0;
  out.scale = std::abs(header.scale);
  out.rate = header.rate;
  return out;
}

void take_scale(C3dLayout& layout, const C3dParameters& parameters) {
  const auto scale = parameters.number("POINT", "SCALE");
  if (!scale || !is_scale(*scale)) return;
  layout.real = *scale < 0;
  layout.scale = std::abs(*scale);
}

C3dLayout layout_of_parameters(const C3dHeader& header, const C3dParameters& parameters) {
  C3dLayout out = layout_of_header(header);
  if (const auto used = parameters.count("POINT", "USED")) out.points = bounded_count(*used) & 0xffff;
  if (const auto used = parameters.count("ANALOG", "USED")) out.channels = bounded_count(*used) & 0xffff;
  if (const auto rate = parameters.number("POINT", "RATE"); rate && is_rate(*rate)) out.rate = *rate;
  const auto analog_rate = parameters.number("ANALOG", "RATE");
  if (header.samples == 0 && out.channels != 0 && analog_rate && is_rate(out.rate) && is_rate(*analog_rate))
    out.samples = std::max<std::uint64_t>(1, bounded_count(std::round(*analog_rate / out.rate)) & 0xffff);
  if (!is_rate(out.rate) && analog_rate && is_rate(*analog_rate))
    out.rate = *analog_rate / static_cast<double>(out.samples);
  out.frames = parameter_frames(header, parameters);
  if (const auto block = parameters.count("POINT", "DATA_START"); block && *block >= 2)
    out.data = (bounded_count(*block) - 1) * c3d_block;
  if (!is_scale(header.scale)) take_scale(out, parameters);
  return out;
}

// The number of the first frame: that of TRIAL or of the header, whichever agrees with the count of frames.
double number_of_first_frame(const C3dHeader& header, const C3dParameters& parameters, std::uint64_t frames) {
  const auto first = trial_field(parameters, "ACTUAL_START_FIELD");
  const auto count = trial_frames(parameters);
  if (first && *first >= 1 && count && *count == static_cast<double>(frames)) return *first;
  return header.first_frame >= 1 ? static_cast<double>(header.first_frame) : 1;
}

bool frames_fit(const C3dLayout& layout, std::uint64_t size) {
  if (layout.data < c3d_block || layout.data > size) return false;
  return layout.frames == 0 || layout.frame_bytes() <= (size - layout.data) / layout.frames;
}

bool frames_fill(const C3dLayout& layout, std::uint64_t size) {
  return frames_fit(layout, size) && size - layout.data - layout.frames * layout.frame_bytes() < c3d_block;
}

constexpr std::uint64_t most_counted = 65535;  // in 16 bits

// Frames from the layout's start to the file's end. Zeros that only fill the last block are none.
std::uint64_t frames_by_size(const C3dLayout& layout, std::string_view bytes) {
  std::uint64_t frames = (bytes.size() - layout.data) / layout.frame_bytes();
  const std::uint64_t last_block = bytes.size() - std::min<std::uint64_t>(bytes.size(), c3d_block);
  for (; frames > layout.frames; --frames) {
    const std::uint64_t begin = layout.data + (frames - 1) * layout.frame_bytes();
    if (begin < last_block || bytes.substr(begin, layout.frame_bytes()).find_first_not_of('\0') != bytes.npos)
      break;
  }
  return frames;
}

bool fits_better(const C3dLayout& other, const C3dLayout& layout, std::uint64_t size) {
  if (other.frames == 0 || other.frame_bytes() == 0) return false;
  return (frames_fit(other, size) && !frames_fit(layout, size)) ||
         (frames_fill(other, size) && !frames_fill(layout, size));
}

bool same_place(const C3dLayout& a, const C3dLayout& b) {
  return a.points == b.points && a.channels == b.channels && a.samples == b.samples && a.frames == b.frames &&
         a.data == b.data && a.real == b.real;
}

std::string layout_in_words(const C3dLayout& layout) {
  return fmt::format("{} frames of {} points and {} x {} analog samples ({} numbers) from byte {}",
                     layout.frames, layout.points, layout.channels, layout.samples,
                     layout.real ? "floating-point" : "integer", layout.data);
}

}  // namespace

Result<C3dLayout> c3d_layout(std::string_view bytes, C3dProcessor processor, const C3dParameters& parameters,
                             const std::string& file, std::vector<std::string>& warnings) {
  const C3dHeader header(bytes.data(), processor);
  C3dLayout out = layout_of_parameters(header, parameters);
  C3dLayout counted = out;  // the header may count the frames right where all else in it is old
  counted.frames = header_frames(header);
  C3dLayout scaled = out;
  take_scale(scaled, parameters);
  if (!out.real && std::abs(scaled.scale - out.scale) > 1e-5 * out.scale)
    warnings.push_back(
        fmt::format("POINT:SCALE is {:g}, but the header's scale is {:g}; the header's was used",
                    scaled.scale, out.scale));
  const C3dLayout first = out;
  for (const C3dLayout& other : {scaled, counted, layout_of_header(header)})
    if (!same_place(out, other) && fits_better(other, out, bytes.size())) {
      const double rate = out.rate;
      out = other;
      if (is_rate(rate)) out.rate = rate;
    }
  if (!same_place(out, first))
    warnings.push_back(
        fmt::format("header and parameters differ: {} do not fit the file's size, {} do and were used",
                    layout_in_words(first), layout_in_words(out)));
  if (out.frames == most_counted && frames_fit(out, bytes.size()) && !frames_fill(out, bytes.size())) {
    out.frames = frames_by_size(out, bytes);
    if (out.frames > most_counted)
      warnings.push_back(
          fmt::format("counts {} frames, the most that its header can; the file's size shows {}",
                      most_counted, out.frames));
  }
  if (out.points == 0 && out.channels == 0)
    return failure(file, "contains neither points nor analog channels");
  if (out.frames == 0) return failure(file, "holds no frames");
  if (!frames_fit(out, bytes.size()))
    return failure(file,
                   fmt::format("has {} bytes, too few for {}, {} bytes each: it is cut short or damaged",
                               bytes.size(), layout_in_words(out), out.frame_bytes()));
  if (!is_rate(out.rate)) return failure(file, "has no frame rate in POINT:RATE nor in its header");
  if (out.points != 0 && !is_scale(out.scale)) return failure(file, "has no scale in POINT:SCALE");
  out.first_frame = number_of_first_frame(header, parameters, out.frames);
  return out;
}

}  // namespace borelli
