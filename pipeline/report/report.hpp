// report.html: one self-contained page that shows what a run found: the moving body, the parts, the inertia
// table beside published ones, the scan with the parts over it, the motion's energies and certificate, the
// run's account.
//
// The page holds its data (JSON, and zlib streams in base64) and its program (pipeline/report, bundled); it
// loads nothing and opens from file://. What is not given is left out of the page.
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

/// A file beside the report that it offers for download.
struct ReportFile {
  std::string path;  ///< relative to the report's folder, with '/'
  std::uintmax_t bytes = 0;
};

/// What a page shows of the scan itself; nothing in it depends on what moves.
struct ScanViews {
  nlohmann::json facts;  ///< what the page's data say of it, by name: histogram, slices, cuts, fits
  std::string packed;    ///< its grey values and labels, as the page holds them
};

struct ReportInputs {
  std::string subject;  ///< any text; becomes the title
  const GreyVolume* grey = nullptr;
  const LabelMap* labels = nullptr;
  nlohmann::json
      segmentation;  ///< segmentation.json (segmentation_files.hpp): findings, how the scan was read
  const Landmarks* landmarks = nullptr;  ///< those named as a joint in parts.hpp are drawn
  nlohmann::json table;                  ///< the inertia table as inertia/table.json has it; null: none
  const Trajectory* trajectory = nullptr;
  std::string_view glb;  ///< bytes of body.glb; empty: no player
  /// Take the face out of the scan's copy (deface.hpp); the surface in `glb` is the caller's to make without.
  bool deface = false;
  nlohmann::json run;  ///< run.json as far as it stands
  std::vector<ReportFile> files;
  const ScanViews* views = nullptr;  ///< as scan_views has them; null: made with the page
};

/// By grey values, labels, landmarks, segmentation and deface of a page's inputs.
Result<ScanViews> scan_views(const ReportInputs& inputs);

/// The page.
Result<std::string> report_page(const ReportInputs& inputs);

/// Writes the page to `path`.
Result<void> write_report(const ReportInputs& inputs, const std::filesystem::path& path);

/// What a run's folder holds that a reader may want, in the order of the stages: every file of the known
/// layout that is there.
std::vector<ReportFile> report_files(const std::filesystem::path& folder);

}  // namespace borelli
