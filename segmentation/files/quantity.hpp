// What the values of a volume file mean, and their conversion to int16.
//
// The file states it only if it is DICOM (CT: Hounsfield units) or if we wrote it. Otherwise the user states
// it, or it is inferred from the values if only one reading fits:
//   hu            air (at least 1 % of the voxels in [-1100, -900]) and soft tissue (at least 1 % in
//                 [-200, 200]); below -1100 less than 1 %, except for one padding value. No other quantity of
//                 a body is negative.
//   density_gcm3  nothing negative or above 25; air (at least 1 % at most 0.02); and of the voxels above 0.1
//                 at least half in [0.85, 1.15], the range of fat, water and muscle, and not exactly 1 as in
//                 a mask.
//   labels        whole numbers from 0 to 255, including 0, and at least 80 % of the neighbours inside are
//                 equal.
// Densities in kg/m3 are never inferred: CT numbers with 1024 added, as some programs store them, look the
// same. Neither is MR, whose values have no calibrated scale.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "segmentation/files/value_range.hpp"

namespace borelli {

/// As Quantity, plus g/cm3, which is converted to kg/m3 on reading.
enum class FileQuantity { hu, density_kgm3, density_gcm3, labels, mr };

/// The name used on the command line: hu, density_kgm3, density_gcm3, labels, mr.
std::string_view quantity_name(FileQuantity quantity);
std::string_view quantity_name(Quantity quantity);

/// For sentences, e.g. "CT numbers (hu)".
std::string_view quantity_words(FileQuantity quantity);

/// Error: not one of the five names.
Result<FileQuantity> parse_quantity(std::string_view name);

Quantity held_as(FileQuantity quantity);  ///< density_gcm3 is stored as density_kgm3

struct QuantityReading {
  FileQuantity quantity = FileQuantity::hu;
  std::string statement;  ///< the quantity and why it was chosen, for the table and run.json
};

/// Decides what the values are: as the user says (`asked`), else as our writer recorded in the file, else by
/// the values (rules above). Errors: values that contradict `asked`; more than one reading or none, with what
/// to specify.
Result<QuantityReading> decide_quantity(const std::string& path, const StoredVoxels& voxels, double slope,
                                        double intercept, const ValueRange& range,
                                        std::optional<FileQuantity> asked, const std::string& recorded);

/// Numbers of voxels whose values were clamped, without padding.
struct Clamped {
  std::int64_t below = 0;  ///< lower than noise in air: CT numbers below -1100, kg/m3 below -100
  std::int64_t above = 0;  ///< above 32767
};

/// Converts the values to int16, in place (no second copy of the volume). hu: padding becomes padding_hu,
/// other values below -1024 become -1024. Densities: g/cm3 is scaled to kg/m3, negative values become 0.
/// Values that are not finite become padding_hu or padding_density, in MR 0. MR is scaled to fit if rounding
/// would lose it. `warnings` lists the changes, with counts. `clamped`, if given, is set.
std::vector<std::int16_t> to_int16(StoredVoxels voxels, double slope, double intercept,
                                   const ValueRange& range, FileQuantity quantity,
                                   std::vector<std::string>& warnings, Clamped* clamped = nullptr);

}  // namespace borelli
