// What the values of a volume file mean, and their way into int16.
//
// A file says what it holds only where it is DICOM (CT: Hounsfield units) or where we wrote it. Any other
// file's meaning is given by the user, or read off its values where they admit one reading:
//   hu            air around (at least 1 % of the voxels in [-1100, -900]) and soft tissue (at least 1 % in
//                 [-200, 200]); below -1100 less than 1 %, one padding value aside. No other quantity of a
//                 body is negative.
//   density_gcm3  nothing negative or above 25; air around (at least 1 % at most 0.02); and of the voxels above
//                 0.1 at least half in [0.85, 1.15], where fat, water and muscle lie, and not just equal to 1
//                 as in a mask.
//   labels        whole numbers from 0 to 255, 0 among them, and at least 80 % of the neighbours inside are
//                 equal.
// Densities in kg/m3 are never inferred: CT numbers with 1024 added, as some programs store them, look the
// same. Nor is MR, whose values have no scale.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "segmentation/files/image_file.hpp"

namespace borelli {

/// As Quantity, and g/cm3, which is scaled to kg/m3 when it is read.
enum class FileQuantity { hu, density_kgm3, density_gcm3, labels, mr };

/// The name used on the command line: hu, density_kgm3, density_gcm3, labels, mr.
std::string_view quantity_name(FileQuantity quantity);
std::string_view quantity_name(Quantity quantity);

/// For sentences, e.g. "CT numbers (hu)".
std::string_view quantity_words(FileQuantity quantity);

/// Error: not one of the five names.
Result<FileQuantity> parse_quantity(std::string_view name);

Quantity held_as(FileQuantity quantity);  ///< density_gcm3 is held as density_kgm3

/// Range and kinds of a volume's values, after slope and intercept.
struct ValueRange {
  double least = 0, greatest = 0;  ///< of the finite values; 0 where there are none
  std::size_t count = 0;
  std::size_t not_finite = 0;  ///< NaN or infinite
  std::size_t fractional = 0;  ///< finite and not a whole number
  std::size_t at_least = 0;    ///< equal to the least

  ValueRange& operator+=(const ValueRange& other);  ///< of these voxels and those
};
ValueRange value_range(const StoredVoxels& voxels, double slope, double intercept);
/// Of the voxels [first, last), by the thread that calls: the others need not be there yet.
ValueRange value_range(const StoredVoxels& voxels, double slope, double intercept, std::size_t first,
                       std::size_t last);

struct QuantityReading {
  FileQuantity quantity = FileQuantity::hu;
  std::string statement;  ///< the quantity and why it was taken as that, for the table and run.json
};

/// Decides what the values are: as asked, else as our writer recorded in the file, else by the values (rule
/// above). Errors: values that cannot be what was asked; more than one reading or none, with what to ask for.
Result<QuantityReading> decide_quantity(const std::string& path, const StoredVoxels& voxels, double slope,
                                        double intercept, const ValueRange& range,
                                        std::optional<FileQuantity> asked, const std::string& recorded);

/// Numbers of voxels whose values were clamped, padding aside.
struct Clamped {
  std::int64_t below = 0;  ///< CT numbers below -1500, lower than noise about air
  std::int64_t above = 0;  ///< above 32767
};

/// The values as int16, in place (no second copy of the volume): hu that is padding is set to padding_hu,
/// other hu below -1024 to -1024, g/cm3 scaled to kg/m3, negative densities to 0; what is not finite was not
/// measured: padding_hu, padding_density, of MR 0. MR is scaled to fit where rounding would lose it. What was
/// changed is said in `warnings`, with counts. `clamped`, if given, is set.
std::vector<std::int16_t> to_int16(StoredVoxels voxels, double slope, double intercept,
                                   const ValueRange& range, FileQuantity quantity,
                                   std::vector<std::string>& warnings, Clamped* clamped = nullptr);

}  // namespace borelli
