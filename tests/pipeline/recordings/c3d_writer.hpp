// Writes small C3D files for tests: all processors, integers and floating-point numbers, any parameters.
// Written from the user guide (www.c3d.org) and shares no code with the reader.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace borelli::test {

struct C3dWriter {
  enum Processor { intel = 84, dec = 85, mips = 86 };
  /// x, y, z in the file's unit, and word 4: -1 for a gap, else 256 * camera mask + residual.
  using Point = std::array<double, 4>;

  Processor processor = intel;
  bool real = true;
  double scale = 0.05;  ///< POINT:SCALE without its sign
  double rate = 100;
  int samples = 1;   ///< analog samples per frame
  int channels = 0;  ///< analog channels
  int first_frame = 1;
  std::vector<std::vector<Point>> frames;    ///< one list of points per frame
  std::vector<std::vector<double>> numbers;  ///< per analog sample one stored number per channel
  std::vector<std::pair<double, std::string>> header_events;
  std::string group_order = "first";  ///< "last": all groups after all parameters
  bool locked = false;                ///< names of negative length
  int parameter_block = 2;            ///< where the parameter section starts
  std::optional<int> header_points, header_frames, counted_blocks;
  std::optional<double> header_scale;

  void text(const std::string& name, const std::vector<std::string>& rows) {
    std::size_t width = 1;
    for (const std::string& row : rows) width = std::max(width, row.size());
    std::string data;
    for (const std::string& row : rows) data += row + std::string(width - row.size(), ' ');
    add(name, -1, {static_cast<int>(width), static_cast<int>(rows.size())}, data);
  }
  void line(const std::string& name, const std::string& row) {
    add(name, -1, {static_cast<int>(row.size())}, row);
  }
  void bytes_of(const std::string& name, const std::vector<int>& values, std::vector<int> dimensions) {
    std::string data;
    for (const int value : values) data += static_cast<char>(value);
    add(name, 1, std::move(dimensions), data);
  }
  void integers(const std::string& name, const std::vector<int>& values, std::vector<int> dimensions) {
    std::string data;
    for (const int value : values) data += word(value);
    add(name, 2, std::move(dimensions), data);
  }
  void integer(const std::string& name, int value) { integers(name, {value}, {}); }
  void reals(const std::string& name, const std::vector<double>& values, std::vector<int> dimensions) {
    std::string data;
    for (const double value : values) data += number(value);
    add(name, 4, std::move(dimensions), data);
  }
  void real_number(const std::string& name, double value) { reals(name, {value}, {}); }

  /// Adds the parameters that every file has, from the counts above.
  void usual_parameters(const std::vector<std::string>& labels, const std::string& unit = "mm") {
    integer("POINT:USED", static_cast<int>(labels.size()));
    integer("POINT:FRAMES", static_cast<int>(frames.size()));
    real_number("POINT:SCALE", real ? -scale : scale);
    real_number("POINT:RATE", rate);
    line("POINT:UNITS", unit);
    if (!labels.empty()) text("POINT:LABELS", labels);
    integer("ANALOG:USED", channels);
    real_number("ANALOG:RATE", rate * samples);
  }

  /// Appends a parameter "GROUP:NAME" of any type and dimensions.
  void add(const std::string& name, int type, std::vector<int> dimensions, const std::string& data) {
    const auto colon = name.find(':');
    parameters_.push_back({name.substr(0, colon), name.substr(colon + 1), type, std::move(dimensions), data});
  }
  void remove(const std::string& group, const std::string& name) {
    std::erase_if(parameters_, [&](const Parameter& p) { return p.group == group && p.name == name; });
  }

  std::string word(int value) const {
    const auto low = static_cast<char>(value & 0xff), high = static_cast<char>(value >> 8 & 0xff);
    return processor == mips ? std::string{high, low} : std::string{low, high};
  }

  /// A floating-point number, rounded to 24 bits of fraction.
  std::string number(double value) const {
    const auto ieee = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    if (processor == intel) return word(static_cast<int>(ieee & 0xffff)) + word(static_cast<int>(ieee >> 16));
    if (processor == mips) return word(static_cast<int>(ieee >> 16)) + word(static_cast<int>(ieee & 0xffff));
    // VAX: 0.5 <= fraction < 1, exponent + 128, the leading bit left out, the high word first
    int exponent = 0;
    const double fraction = std::frexp(std::abs(static_cast<double>(static_cast<float>(value))), &exponent);
    std::uint32_t bits = 0;
    if (value != 0)
      bits = (value < 0 ? 0x80000000U : 0U) | static_cast<std::uint32_t>(exponent + 128) << 23 |
             (static_cast<std::uint32_t>(std::ldexp(fraction, 24)) & 0x7fffffU);
    return word(static_cast<int>(bits >> 16)) + word(static_cast<int>(bits & 0xffff));
  }

  /// The whole file. DATA_START is added.
  std::string bytes() const {
    std::string section = parameter_section(0);
    const int blocks = static_cast<int>((section.size() + 511) / 512);
    const int data_block = parameter_block + blocks;
    section = parameter_section(data_block);
    section.resize(static_cast<std::size_t>(512 * blocks), '\0');
    section[2] = static_cast<char>(counted_blocks.value_or(blocks));
    std::string out = header(data_block);
    out.resize(static_cast<std::size_t>(512 * (parameter_block - 1)), '\0');
    out += section + data();
    out.resize((out.size() + 511) / 512 * 512, '\0');
    return out;
  }

 private:
  struct Parameter {
    std::string group, name;
    int type;
    std::vector<int> dimensions;
    std::string data;
  };

  std::string name_record(const std::string& name, int group) const {
    const int length = static_cast<int>(name.size());
    return std::string{static_cast<char>(locked ? -length : length), static_cast<char>(group)} + name;
  }

  std::string parameter_section(int data_block) const {
    std::vector<Parameter> all = parameters_;
    all.push_back({"POINT", "DATA_START", 2, {}, word(data_block)});
    std::vector<std::string> groups, group_records, records;
    for (const Parameter& p : all) {
      std::size_t number = 0;
      while (number < groups.size() && groups[number] != p.group) ++number;
      if (number == groups.size()) {
        groups.push_back(p.group);
        group_records.push_back(name_record(p.group, -static_cast<int>(number + 1)) + word(2 + 1 + 4) + '\4' +
                                "text");
      }
      std::string body{static_cast<char>(p.type), static_cast<char>(p.dimensions.size())};
      for (const int d : p.dimensions) body += static_cast<char>(d);
      body += p.data + '\3' + "why";
      records.push_back(name_record(p.name, static_cast<int>(number + 1)) +
                        word(static_cast<int>(2 + body.size())) + body);
    }
    std::string out("\1\x50\0", 3);
    out += static_cast<char>(processor);
    if (group_order == "first")
      for (const std::string& record : group_records) out += record;
    for (const std::string& record : records) out += record;
    if (group_order == "last")
      for (const std::string& record : group_records) out += record;
    return out + std::string(2, '\0');
  }

  std::string header(int data_block) const {
    const int points = frames.empty() ? 0 : static_cast<int>(frames[0].size());
    const double sign = real ? -1 : 1;
    std::string out{static_cast<char>(parameter_block), 'P'};
    out += word(header_points.value_or(points)) + word(channels * samples) + word(first_frame);
    out += word(first_frame + header_frames.value_or(static_cast<int>(frames.size())) - 1) + word(10);
    out += number(header_scale.value_or(sign * scale)) + word(data_block) + word(samples) + number(rate);
    out.resize(298, '\0');
    out += word(12345) + word(static_cast<int>(header_events.size())) + word(0);
    for (const auto& [time, label] : header_events) out += number(time);
    out.resize(396, '\0');
    for (const auto& [time, label] : header_events) out += (label + "    ").substr(0, 4);
    out.resize(512, '\0');
    return out;
  }

  std::string stored(double value) const {
    return real ? number(value) : word(static_cast<int>(std::lround(value)));
  }

  std::string data() const {
    std::string out;
    std::size_t sample = 0;
    for (const std::vector<Point>& frame : frames) {
      for (const Point& p : frame) {
        for (int i = 0; i < 3; ++i)
          out += stored(real ? p[static_cast<std::size_t>(i)] : p[static_cast<std::size_t>(i)] / scale);
        out += stored(p[3]);
      }
      for (int i = 0; i < (channels == 0 ? 0 : samples); ++i, ++sample)
        for (int c = 0; c < channels; ++c) out += stored(numbers.at(sample).at(static_cast<std::size_t>(c)));
    }
    return out;
  }

  std::vector<Parameter> parameters_;
};

}  // namespace borelli::test
