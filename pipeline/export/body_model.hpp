// Landmarks, deviations and meshes of a scanned body for model files of other programs, in addition to its
// scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/formats/model_write.hpp"
#include "inertia/table.hpp"
#include "pipeline/body/skeleton.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// The scene of a body with its landmarks as markers, named after them, each on the part that carries it
/// (data/marker_names.csv; a joint centre on the part beyond the joint). Landmarks of parts that the scene
/// lacks, and names that it has already, are left out. `present` and `landmarks`: those that the scene was
/// built from.
Scene with_landmark_markers(Scene scene, const PartInertials& present, const Landmarks& landmarks);

/// Comments: the scan, how the table was made, the standard deviations of each part's mass, gravity centre
/// (m) and tensor (kg m^2) in patient axes, and of the joint centres (mm). Frames: the anatomical axes of
/// each part. Meshes: `mesh_files`, named after their parts; coordinates in patient axes, m.
ModelExtras body_extras(const InertiaTable& table, const PartInertials& present, const Landmarks& landmarks,
                        const std::vector<std::filesystem::path>& mesh_files);

}  // namespace borelli
