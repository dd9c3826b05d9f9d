// Writes report.html, one self-contained page with the results of a run: the moving body, the parts, the
// inertia table beside published ones, the scan with its parts, the motion's energies and certificate, and
// the run's account.
//
// The page holds its data (JSON, and zlib streams in base64) and its program (pipeline/report, bundled). It
// loads nothing and opens from file://. Missing inputs are left out of the page.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A file that the report offers for download.
struct ReportFile {
  std::string path;  ///< relative to the report's folder, with '/'
  std::uintmax_t bytes = 0;
};

/// The page's views of the scan; they do not depend on the motion.
struct ScanViews {
  nlohmann::json facts;  ///< by name: histogram, slices, cuts, fits
  std::string packed;    ///< grey values and labels, encoded as in the page
};

struct ReportInputs {
  std::string subject;  ///< any text; becomes the title
  const GreyVolume* grey = nullptr;
  const LabelMap* labels = nullptr;
  nlohmann::json
      segmentation;  ///< segmentation.json (segmentation_files.hpp): findings, how the scan was read
  const Landmarks* landmarks = nullptr;  ///< those named as a joint in parts.hpp are drawn
  nlohmann::json table;                  ///< as in inertia/table.json; null: none
  const Trajectory* trajectory = nullptr;
  std::string_view glb;  ///< bytes of body.glb; empty: no player
  /// Remove the face from the scan's copy (deface.hpp). The caller removes it from the surface in `glb`.
  bool deface = false;
  nlohmann::json efforts;  ///< motion/efforts.json (pipeline/motion/effort_report.hpp); null: none
  nlohmann::json run;      ///< run.json so far
  std::vector<ReportFile> files;
  const ScanViews* views = nullptr;  ///< result of scan_views; null: computed with the page
};

/// Views from the grey values, labels, landmarks, segmentation and deface of a page's inputs.
Result<ScanViews> scan_views(const ReportInputs& inputs);

/// Returns the page.
Result<std::string> report_page(const ReportInputs& inputs);

/// Writes the page to `path`.
Result<void> write_report(const ReportInputs& inputs, const std::filesystem::path& path);

/// All existing files of the known layout in a run's folder, in the order of the stages.
std::vector<ReportFile> report_files(const std::filesystem::path& folder);

}  // namespace borelli
