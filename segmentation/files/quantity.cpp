#include "segmentation/files/quantity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <type_traits>

#include "threads/clones.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

constexpr std::array<std::string_view, 5> names{"hu", "density_kgm3", "density_gcm3", "labels", "mr"};
constexpr std::array<std::string_view, 5> words{"CT numbers (hu)", "densities in kg/m3 (density_kgm3)",
                                                "densities in g/cm3 (density_gcm3)", "labels",
                                                "MR signal (mr)"};

std::string in_words(FileQuantity q) { return std::string(quantity_words(q)); }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string percent(std::size_t part, std::size_t whole) {
  return number(whole ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0) + " %";
}

std::string span_of(const ValueRange& r) {
  return "values from " + number(r.least) + " to " + number(r.greatest);
}

// Numbers of voxels in the ranges that each quantity requires.
struct Signs {
  std::size_t count = 0;
  std::size_t ct_air = 0, ct_soft = 0,
              stray = 0;  // [-1100, -900]; [-200, 200]; below -1100 and not the least value
  std::size_t vacuum = 0, dense = 0, tissue = 0;  // <= 0.02; > 0.1; [0.85, 1.15] and not 1
  std::size_t inside_pairs = 0, equal_pairs = 0;  // neighbours along i, both not 0; of those equal
};

Signs signs_of(const StoredVoxels& voxels, double slope, double intercept, double least) {
  Signs s;
  s.count = voxels.count;
  std::mutex mutex;
  in_slabs(static_cast<std::int64_t>(voxels.count), 0, [&](std::int64_t from, std::int64_t to) {
    Signs own;
    const auto count = [&](const auto& read, std::size_t first, std::size_t last) {
      using Number = decltype(read(first));
      const auto bottom = static_cast<Number>(least);
      std::uint32_t air = 0, soft = 0, stray = 0, vacuum = 0, dense = 0, tissue = 0, inside = 0, equal = 0;
      for (std::size_t n = first; n < last; ++n) {
        const Number v = read(n);
        air += (v >= -1100) & (v <= -900);
        soft += (v >= -200) & (v <= 200);
        stray += (v < -1100) & (v > bottom);
        if constexpr (std::is_same_v<Number, double>) {
          vacuum += v <= 0.02;
          dense += v > 0.1;
          tissue += (v >= 0.85) & (v <= 1.15) & (v != 1);
        } else {
          vacuum += v <= 0;
          dense += v > 0;
        }
      }
      for (std::size_t n = std::max<std::size_t>(first, 1); n < last; ++n) {
        const Number before = read(n - 1), v = read(n);
        inside += (v != 0) & (before != 0);
        equal += (v != 0) & (v == before);
      }
      own.ct_air += air, own.ct_soft += soft, own.stray += stray;
      own.vacuum += vacuum, own.dense += dense, own.tissue += tissue;
      own.inside_pairs += inside, own.equal_pairs += equal;
    };
    each_block(voxels, static_cast<std::size_t>(from), static_cast<std::size_t>(to), slope, intercept, count);
    const std::lock_guard lock(mutex);
    s.ct_air += own.ct_air, s.ct_soft += own.ct_soft, s.stray += own.stray;
    s.vacuum += own.vacuum, s.dense += own.dense, s.tissue += own.tissue;
    s.inside_pairs += own.inside_pairs, s.equal_pairs += own.equal_pairs;
  });
  return s;
}

bool at_least(std::size_t part, double share, std::size_t whole) {
  return static_cast<double>(part) >= share * static_cast<double>(whole);
}

bool may_be_hu(const Signs& s) {
  return at_least(s.ct_air, 0.01, s.count) && at_least(s.ct_soft, 0.01, s.count) &&
         !at_least(s.stray, 0.01, s.count);
}

bool may_be_gcm3(const Signs& s, const ValueRange& r) {
  return r.least >= 0 && r.greatest <= 25 && at_least(s.vacuum, 0.01, s.count) && s.dense > 0 &&
         at_least(s.tissue, 0.5, s.dense);
}

bool may_be_labels(const Signs& s, const ValueRange& r) {
  return r.fractional == 0 && r.not_finite == 0 && r.least == 0 && r.greatest >= 1 && r.greatest <= 255 &&
         at_least(s.equal_pairs, 0.8, s.inside_pairs) && s.inside_pairs > 0;
}

Result<QuantityReading> by_values(const std::string& path, const Signs& s, const ValueRange& r) {
  std::vector<QuantityReading> readings;
  const auto admit = [&](FileQuantity q, const std::string& why) {
    readings.push_back(
        {q, in_words(q) + ": its values allow no other reading (" + span_of(r) + ", " + why + ")"});
  };
  if (may_be_hu(s))
    admit(FileQuantity::hu, percent(s.ct_air, s.count) + " near air's -1000 and " +
                                percent(s.ct_soft, s.count) + " near water's 0");
  if (may_be_gcm3(s, r))
    admit(FileQuantity::density_gcm3,
          percent(s.tissue, s.dense) + " of the voxels other than air near water's 1");
  if (may_be_labels(s, r))
    admit(FileQuantity::labels,
          "whole numbers, " + percent(s.equal_pairs, s.inside_pairs) + " of neighbouring voxels equal");
  if (readings.size() == 1) return readings.front();
  std::string found = span_of(r) + (r.fractional ? "" : ", whole numbers") + ", that ";
  if (readings.empty()) {
    found += "fit no reading";
  } else {
    found += "could be " + in_words(readings[0].quantity) + " or " + in_words(readings[1].quantity);
  }
  return bad_use(path, "does not state what its voxels hold, and it has " + found +
                           "; give --quantity hu, density_kgm3, density_gcm3, labels or mr");
}

// Which quantity the refused values may be, e.g. "in g/cm3 it is density_gcm3"; empty if unclear.
std::string advice(const Signs& s, const ValueRange& r) {
  if (may_be_hu(s)) return "; for CT numbers give hu";
  if (may_be_gcm3(s, r)) return "; for g/cm3 give density_gcm3";
  if (may_be_labels(s, r)) return "; for a label map give labels";
  // a body in kg/m3; interpolation may overshoot below 0
  if (r.least >= -300 && r.greatest >= 100 && r.greatest <= 25000) return "; for kg/m3 give density_kgm3";
  return "";
}

// refuses values that contradict the stated quantity
Result<void> check(const std::string& path, FileQuantity q, const ValueRange& r,
                   const std::function<std::string()>& advised) {
  const auto refuse = [&](const std::string& why) {
    return bad_use(path, "is not a volume of " + in_words(q) + ": " + why);
  };
  // osmium, the densest element, has 22.6 g/cm3; any body exceeds 100 kg/m3 somewhere
  if (q == FileQuantity::density_gcm3 && r.greatest > 25) return refuse(span_of(r) + advised());
  if (q == FileQuantity::density_kgm3 && r.greatest < 25) return refuse(span_of(r) + advised());
  if (q == FileQuantity::density_kgm3 && r.greatest > 25000) return refuse(span_of(r));
  // interpolation may overshoot slightly below air's 0; CT numbers go down to -1000
  const double scale = q == FileQuantity::density_gcm3 ? 1 : 1000;
  if ((q == FileQuantity::density_kgm3 || q == FileQuantity::density_gcm3) && r.least < -0.3 * scale)
    return refuse(span_of(r) + ", and a density cannot be negative" + advised());
  if (q == FileQuantity::labels) {
    if (r.fractional || r.not_finite)
      return refuse(std::to_string(r.fractional + r.not_finite) + " of its values are not whole numbers");
    if (r.least < 0 || r.greatest > 32767) return refuse(span_of(r) + "; labels range from 0 to 32767");
  }
  return {};
}

struct Changes {
  std::size_t below = 0, above = 0, not_finite = 0, padding = 0;
  std::size_t far_below = 0;  // part of `below`, lower than noise in air

  Changes& operator+=(const Changes& other) {
    below += other.below, above += other.above, not_finite += other.not_finite, padding += other.padding;
    far_below += other.far_below;
    return *this;
  }
};

constexpr std::int32_t below_noise = -1100, below_zero = -100;  // lower than noise in air: HU; kg/m3

// The padding value: lower than any noise in air, and more frequent than chance. NaN: none.
double padding_of(const ValueRange& r) {
  constexpr double share = 1e-3;
  return r.least < below_noise && at_least(r.at_least, share, r.count)
             ? r.least
             : std::numeric_limits<double>::quiet_NaN();
}

// Conversion of 16-bit whole numbers: times * (stored & mask) + plus, clamped from `least` to 32767; the
// value `unseen` becomes padding_hu.
struct Whole {
  std::int32_t mask, times, plus, least, far, unseen;
};

BORELLI_VECTOR_CLONES
Changes convert_whole(std::int16_t* at, std::int64_t count, const Whole& whole) {
  const auto [mask, times, plus, least, lowest, unseen] = whole;
  constexpr std::int32_t greatest = 32767;
  Changes changes;
  constexpr std::int64_t together = 1 << 15;
  for (std::int64_t from = 0; from < count; from += together) {
    const std::int64_t to = std::min(from + together, count);
    std::uint32_t below = 0, above = 0, padded = 0, far = 0;
    for (std::int64_t n = from; n < to; ++n) {
      const std::int32_t value = times * (at[n] & mask) + plus;
      const bool seen = value != unseen;
      padded += !seen;
      below += seen & (value < least);
      far += seen & (value < lowest);
      above += value > greatest;
      const std::int32_t clamped = std::max(least, std::min(value, greatest));
      at[n] = static_cast<std::int16_t>(seen ? clamped : padding_hu);
    }
    changes.below += below, changes.above += above, changes.padding += padded, changes.far_below += far;
  }
  return changes;
}

// As convert, if are_whole: `low`, and `padding` unless NaN, are whole too.
template <class T>
Changes convert_whole(std::vector<std::int16_t>& storage, std::size_t count, double slope, double intercept,
                      double low, double far, double padding) {
  const Whole whole{
      .mask = std::is_signed_v<T> ? -1 : 0xffff,
      .times = static_cast<std::int32_t>(slope),
      .plus = static_cast<std::int32_t>(intercept),
      .least = static_cast<std::int32_t>(low),
      .far = static_cast<std::int32_t>(far),
      // (larger than any value)
      .unseen =
          std::isnan(padding) ? std::numeric_limits<std::int32_t>::max() : static_cast<std::int32_t>(padding),
  };
  Changes changes;
  std::mutex mutex;
  in_slabs(static_cast<std::int64_t>(count), 0, [&](std::int64_t first, std::int64_t last) {
    const Changes own = convert_whole(storage.data() + first, last - first, whole);
    const std::lock_guard lock(mutex);
    changes += own;
  });
  storage.resize(count);
  return changes;
}

// converts each value to int16, in place of the stored bytes
template <class T>
Changes convert(std::vector<std::int16_t>& storage, std::size_t count, double slope, double intercept,
                double low, double far, std::int16_t fill, double padding) {
  if (sizeof(T) < 2) storage.resize(count);
  unsigned char* const bytes = reinterpret_cast<unsigned char*>(storage.data());
  const auto one = [&](std::size_t n, std::size_t at, Changes& changes) {
    T stored;
    std::memcpy(&stored, bytes + n * sizeof(T), sizeof stored);
    const double value = slope * static_cast<double>(stored) + intercept;
    std::int16_t out = fill;
    if (!std::isfinite(value)) {
      ++changes.not_finite;
    } else if (value == padding) {
      ++changes.padding;
      out = padding_hu;
    } else {
      changes.below += value<low, changes.above += value> 32767;
      changes.far_below += value < far;
      out = static_cast<std::int16_t>(std::lrint(std::clamp(value, low, 32767.0)));
    }
    std::memcpy(bytes + 2 * at, &out, 2);
  };
  // No result overwrites unread values. If voxels grow, conversion runs backwards. Else each slab is written
  // forwards from its own start, then moved into place.
  Changes changes;
  if constexpr (sizeof(T) < 2) {
    for (std::size_t n = count; n-- > 0;) one(n, n, changes);
  } else {
    std::mutex mutex;
    std::vector<std::pair<std::size_t, std::size_t>> slabs;
    in_slabs(static_cast<std::int64_t>(count), 0, [&](std::int64_t from, std::int64_t to) {
      const auto first = static_cast<std::size_t>(from), last = static_cast<std::size_t>(to);
      Changes own;
      for (std::size_t n = first, at = first * sizeof(T) / 2; n < last; ++n, ++at) one(n, at, own);
      const std::lock_guard lock(mutex);
      changes += own;
      slabs.emplace_back(first, last - first);
    });
    std::ranges::sort(slabs);
    for (const auto& [first, length] : slabs)
      std::memmove(bytes + 2 * first, bytes + sizeof(T) * first, 2 * length);
  }
  storage.resize(count);
  storage.shrink_to_fit();
  return changes;
}

// MR has no calibrated scale: values too small or too large for int16 are rescaled
double mr_scale(const ValueRange& r) {
  const double most = std::max(std::abs(r.least), std::abs(r.greatest));
  if (most == 0 || (most <= 32767 && (r.fractional == 0 || most >= 1000))) return 1;
  return 30000 / most;
}

}  // namespace

std::string_view quantity_name(FileQuantity quantity) { return names[static_cast<std::size_t>(quantity)]; }

std::string_view quantity_words(FileQuantity quantity) { return words[static_cast<std::size_t>(quantity)]; }

std::string_view quantity_name(Quantity quantity) {
  switch (quantity) {
    case Quantity::hu:
      return "hu";
    case Quantity::density_kgm3:
      return "density_kgm3";
    case Quantity::labels:
      return "labels";
    case Quantity::mr:
      return "mr";
  }
  return "";
}

Result<FileQuantity> parse_quantity(std::string_view name) {
  for (std::size_t n = 0; n < names.size(); ++n)
    if (names[n] == name) return static_cast<FileQuantity>(n);
  return bad_use("quantity", "'" + std::string(name) +
                                 "' is not a quantity; choose hu, density_kgm3, density_gcm3, labels or mr");
}

Quantity held_as(FileQuantity quantity) {
  switch (quantity) {
    case FileQuantity::hu:
      return Quantity::hu;
    case FileQuantity::labels:
      return Quantity::labels;
    case FileQuantity::mr:
      return Quantity::mr;
    default:
      return Quantity::density_kgm3;
  }
}

Result<QuantityReading> decide_quantity(const std::string& path, const StoredVoxels& voxels, double slope,
                                        double intercept, const ValueRange& range,
                                        std::optional<FileQuantity> asked, const std::string& recorded) {
  if (range.not_finite == range.count) return failure(path, "contains no finite number");
  QuantityReading reading;
  if (asked) {
    reading = {*asked, in_words(*asked) + ": as requested"};
  } else if (const auto own = parse_quantity(recorded)) {
    reading = {*own, in_words(*own) + ": as the file's own header states"};
  } else {
    const auto found = by_values(path, signs_of(voxels, slope, intercept, range.least), range);
    if (!found) return found;
    reading = *found;
  }
  const auto advised = [&] { return advice(signs_of(voxels, slope, intercept, range.least), range); };
  if (const auto fine = check(path, reading.quantity, range, advised); !fine)
    return tl::unexpected(fine.error());
  return reading;
}

std::vector<std::int16_t> to_int16(StoredVoxels voxels, double slope, double intercept,
                                   const ValueRange& range, FileQuantity quantity,
                                   std::vector<std::string>& warnings, Clamped* clamped) {
  double low = -32768, far = low;
  std::int16_t fill = 0;
  double padding = std::numeric_limits<double>::quiet_NaN();
  if (quantity == FileQuantity::hu)
    low = -1024, far = below_noise, fill = padding_hu, padding = padding_of(range);
  if (quantity == FileQuantity::density_kgm3) low = 0, far = below_zero, fill = padding_density;
  if (quantity == FileQuantity::density_gcm3)
    low = 0, far = below_zero, fill = padding_density, slope *= 1000, intercept *= 1000;
  if (quantity == FileQuantity::mr) {
    if (const double scale = mr_scale(range); scale != 1) {
      slope *= scale, intercept *= scale;
      warnings.push_back("the MR signal (" + span_of(range) + ") was multiplied by " + number(scale) +
                         " to keep its steps as whole numbers");
    }
  }
  const Changes changes = with_scalar(voxels.scalar, [&]<class T>(T) {
    if (std::is_same_v<T, std::int16_t> && slope == 1 && intercept == 0 && range.least >= low &&
        std::isnan(padding))
      return Changes{};  // already the result
    if constexpr (std::is_integral_v<T> && sizeof(T) == 2)
      if (are_whole(voxels, slope, intercept))
        return convert_whole<T>(voxels.storage, voxels.count, slope, intercept, low, far, padding);
    return convert<T>(voxels.storage, voxels.count, slope, intercept, low, far, fill, padding);
  });
  const auto tell = [&](std::size_t count, const std::string& what) {
    if (count > 0)
      warnings.push_back(std::to_string(count) + " voxels (" + percent(count, voxels.count) + ") " + what);
  };
  tell(changes.padding, "at " + number(range.least) + " are padding, which the scanner did not see");
  tell(changes.below,
       "below " + number(low) + " (from " + number(range.least) + ") were set to " + number(low));
  tell(changes.above, "above 32767 (up to " + number(range.greatest) + ") were set to 32767");
  tell(changes.not_finite, quantity == FileQuantity::mr
                               ? "are not finite numbers and were read as no signal (0)"
                               : "are not finite numbers; the scan does not show what is there");
  if (clamped)
    *clamped = {.below = static_cast<std::int64_t>(changes.far_below),
                .above = static_cast<std::int64_t>(changes.above)};
  return std::move(voxels.storage);
}

}  // namespace borelli
