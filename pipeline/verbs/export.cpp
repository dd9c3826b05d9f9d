// borelli export LABELS -o FOLDER: one mesh per body part, a picture of them, the labels as DICOM.
#include <fmt/core.h>

#include <filesystem>
#include <optional>

#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/export/mesh_file.hpp"
#include "pipeline/export/render.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct ExportAsked {
  std::string labels, names, folder, landmarks, table, volume, units = "m";
  bool stl = false, vtp = false, ply = false, obj = false, picture = false, dicom = false, patient = false;
  double tolerance_mm = 1;

  bool only_dicom() const { return dicom && !stl && !vtp && !ply && !obj && !picture; }
  fs::path dicom_file() const { return fs::path(folder) / "labels.dcm"; }

  // STL and VTP if nothing is named
  MeshFormats formats() const {
    const bool both = !stl && !vtp && !ply && !obj && !picture && !dicom;
    return {stl || both, vtp || both, ply, obj, units == "mm" ? MeshUnit::millimetre : MeshUnit::metre};
  }
};

// joint centres of a landmark file, in the world frame
Result<std::vector<Eigen::Vector3d>> joints_of(const Command& command, const std::string& path) {
  std::vector<Eigen::Vector3d> centres;
  if (path.empty()) return centres;
  const auto given = read_given_landmarks(command, path);
  if (!given) return tl::unexpected(given.error());
  const Landmarks landmarks = given->all();
  for (const Part& part : parts)
    if (const auto joint = landmarks.find(part.joint); joint != landmarks.end())
      centres.push_back(1e-3 * joint->second.point);
  return centres;
}

// Nothing where no table is given.
Result<std::optional<InertiaTable>> table_of(const Command& command, const std::string& path) {
  if (path.empty()) return std::nullopt;
  auto table = read_table(command, path);
  if (!table) return tl::unexpected(table.error());
  return std::move(*table);
}

// gives each mesh its part's mean density
void add_densities(const InertiaTable& table, std::vector<Mesh>& meshes) {
  for (Mesh& mesh : meshes)
    for (const InertiaRow& row : table.rows)
      if (row.part == mesh.name && row.volume > 0) mesh.density = row.inertial.mass / row.volume;
}

json account(const std::vector<Mesh>& meshes, const std::vector<fs::path>& files) {
  json answer;
  for (const Mesh& mesh : meshes) {
    answer["parts"].push_back({{"name", mesh.name},
                               {"triangles", mesh.triangles.size()},
                               {"volume_m3", enclosed_volume(mesh)},
                               {"closed", is_closed(mesh)}});
  }
  for (const auto& file : files) answer["files"].push_back(file.string());
  return answer;
}

// Makes and writes the meshes and the picture. `files`: those that are written already.
Result<json> export_meshes(const ExportAsked& wanted, const Command& command, const LabelMap& labels,
                           const std::vector<Eigen::Vector3d>& joints,
                           const std::optional<InertiaTable>& table, std::vector<fs::path> files) {
  const fs::path folder = wanted.folder, picture = folder / "body.png";
  ProgressBar bar(command.json);
  bar.begin("meshes");
  auto meshes = part_meshes(labels, {1e-3 * wanted.tolerance_mm, command.threads, [&](double share) {
                                       bar.update(share);
                                       return true;
                                     }});
  if (!meshes) return tl::unexpected(meshes.error());
  if (meshes->empty()) return failure(wanted.labels, "contains no labelled voxel");
  bar.end(fmt::format("{} parts", meshes->size()));

  if (table) add_densities(*table, *meshes);
  const auto written = write_meshes(folder, *meshes, wanted.formats());
  if (!written) return tl::unexpected(written.error());
  files.insert(files.end(), written->begin(), written->end());
  if (wanted.picture) {
    const auto drawn = write_whole(picture, [&](const fs::path& beside) {
      return draw_body(beside.string(), *meshes, {.joints = joints});
    });
    if (!drawn) return tl::unexpected(drawn.error());
    files.push_back(picture);
  }
  if (!command.json) {
    fmt::print("{:<18} {:>10} {:>10}\n", "part", "triangles", "litres");
    for (const Mesh& mesh : *meshes)
      fmt::print("{:<18} {:>10} {:>10.3f}\n", mesh.name, mesh.triangles.size(), 1e3 * enclosed_volume(mesh));
    fmt::print("wrote {} files to {}\n", files.size(), wanted.folder);
  }
  return account(*meshes, files);
}

// The scan that the labels belong to, after a check that labels.dcm can be written. Nothing if it is not
// asked for.
Result<std::optional<DicomSource>> scan_of(const ExportAsked& wanted) {
  if (!wanted.dicom) return std::nullopt;
  if (auto fine = check_writable(wanted.dicom_file(), {wanted.labels, wanted.volume}); !fine)
    return tl::unexpected(fine.error());
  if (wanted.volume.empty()) return std::nullopt;
  auto source = read_dicom_source(wanted.volume);
  if (!source) return tl::unexpected(source.error());
  return std::move(*source);
}

Result<json> run(const ExportAsked& wanted, const Command& command) {
  if (wanted.picture)  // reported before the work
    if (auto fine = can_draw(); !fine) return tl::unexpected(fine.error());
  const fs::path folder = wanted.folder, picture = folder / "body.png";
  if (auto fine = wanted.picture ? check_writable(picture) : check_folder_writable(folder); !fine)
    return tl::unexpected(fine.error());
  const auto joints = joints_of(command, wanted.landmarks);
  if (!joints) return tl::unexpected(joints.error());
  const auto table = table_of(command, wanted.table);
  if (!table) return tl::unexpected(table.error());
  const auto source = scan_of(wanted);
  if (!source) return tl::unexpected(source.error());
  const auto labels = read_labels(command, wanted.labels, wanted.names, *source ? &(*source)->grid : nullptr);
  if (!labels) return tl::unexpected(labels.error());

  std::vector<fs::path> files;
  if (wanted.dicom) {
    const auto written =
        write_dicom_label_file(wanted.dicom_file(), *labels, *source ? &**source : nullptr, wanted.patient);
    if (!written) return tl::unexpected(written.error());
    files.push_back(wanted.dicom_file());
    if (!command.json) fmt::print("wrote {}\n", wanted.dicom_file().string());
  }
  return wanted.only_dicom() ? account({}, files)
                             : export_meshes(wanted, command, *labels, *joints, *table, std::move(files));
}

}  // namespace

void add_export(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand(
      "export", "Write one mesh per body part, a picture of the body, the labels as DICOM");
  auto wanted = std::make_shared<ExportAsked>();
  verb->add_option("labels", wanted->labels, "Label map: .nii.gz, .nrrd or .mha")->required();
  add_output(*verb, wanted->folder, "FOLDER", "Folder for the files")->required();
  add_shared(*verb, flags::label_names, wanted->names);
  verb->add_flag("--stl", wanted->stl,
                 "Write meshes as STL (default if no format and no picture is named: STL and VTP)");
  verb->add_flag("--vtp", wanted->vtp, "Write meshes as VTP, with the part's name, number and density");
  verb->add_flag("--ply", wanted->ply, "Write meshes as PLY");
  verb->add_flag("--obj", wanted->obj, "Write meshes as OBJ");
  verb->add_option("--units", wanted->units, "Unit of the meshes' coordinates: m, or mm as 3D Slicer expects")
      ->check(one_of({"m", "mm"}))
      ->capture_default_str();
  add_shared(*verb, flags::mesh_tolerance, wanted->tolerance_mm)->capture_default_str();
  verb->add_option("--table", wanted->table, "Inertia table (.json), for the densities in VTP files")
      ->type_name("FILE");
  verb->add_flag("--picture", wanted->picture, "Draw a picture, body.png");
  add_shared(*verb, flags::landmarks, wanted->landmarks, "; the picture shows the joint centres");
  auto* dicom = add_shared(*verb, flags::dicom, wanted->dicom);
  auto* volume = add_shared(*verb, flags::volume, wanted->volume,
                            "; the scan that the labels belong to, DICOM, to which labels.dcm refers")
                     ->needs(dicom);
  add_shared(*verb, flags::patient, wanted->patient)->needs(volume);
  group_options(*verb, "Meshes",
                {"--stl", "--vtp", "--ply", "--obj", "--units", "--mesh-tolerance-mm", "--table"});
  group_options(*verb, "Picture", {"--picture", "--landmarks"});
  group_options(*verb, "DICOM", {"--dicom", "--volume", "--patient"});
  verb->callback([&command, wanted] {
    command.work = [wanted](const Command& chosen) { return run(*wanted, chosen); };
  });
}

}  // namespace borelli
