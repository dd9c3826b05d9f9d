// borelli phantom -o phantom.nii.gz: the sample body as a scan, with its exact inertia table.
//
// Beside NAME.nii.gz (or .nrrd, .mha) it writes NAME_labels.* with its names, NAME_table.json and .csv (exact
// mass, gravity centre and tensor of each segment) and NAME_landmarks.json (exact joint centres). With --walk
// STEM also a made-up motion capture of the body: STEM.trc, STEM_grf.mot and STEM_moments.sto.
#include <fmt/core.h>

#include <array>
#include <charconv>
#include <filesystem>

#include "inertia/table_file.hpp"
#include "pipeline/body/segment_rows.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/sample_walk.hpp"
#include "pipeline/motion/walk_markers.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/trc_file.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "process/memory.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/volume_formats.hpp"
#include "segmentation/files/write.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct PhantomAsked {
  std::string output, sex = "male", walk;
  std::vector<std::string> angles;
  std::vector<double> spacing{3}, rotation_deg{0, 0, 0}, offset{0, 0, 0}, crop;
  bool seed_chosen = false, sex_chosen = false;
  PhantomOptions body;
  GridOptions grid;
  ScanOptions scan;
};

// "knee_left_flexion=30"
Result<std::pair<std::string, double>> angle_from(const std::string& text) {
  const auto equals = text.find('=');
  double value = 0;
  if (equals != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + equals + 1, end, value);
    if (read.ec == std::errc() && read.ptr == end) return std::pair{text.substr(0, equals), value};
  }
  return bad_use(
      "--angle",
      fmt::format("'{}' is not a joint angle; expected a form like knee_left_flexion=30, in degrees", text));
}

Result<void> settle(PhantomAsked& asked) {
  if (asked.seed_chosen && asked.scan.noise_hu == 0)
    return bad_use("--seed", "applies only to noise; add --noise");
  if (asked.sex_chosen && asked.body.child)
    return bad_use(
        "--sex",
        "has no effect with --child: a six-year-old has the same proportions as girl and boy; leave it out");
  if (asked.scan.streaks_hu > 0 && asked.body.metal_hip.empty())
    return bad_use("--streaks", "applies only to metal; add --metal-hip");
  if (!asked.walk.empty() && !asked.angles.empty())
    return bad_use("--walk", "applies only to the standing body; leave out --angle");
  if (!asked.crop.empty())
    for (int c = 0; c < 3; ++c) {
      asked.grid.crop_low[c] = asked.crop[static_cast<std::size_t>(2 * c)];
      asked.grid.crop_high[c] = asked.crop[static_cast<std::size_t>(2 * c + 1)];
    }
  asked.body.sex = asked.sex == "female" ? Sex::female : Sex::male;
  for (const std::string& text : asked.angles) {
    const auto angle = angle_from(text);
    if (!angle) return tl::unexpected(angle.error());
    if (!asked.body.pose_deg.insert(*angle).second)
      return bad_use("--angle", fmt::format("{} is given twice", angle->first));
  }
  if (asked.spacing.size() == 1) asked.spacing.resize(3, asked.spacing[0]);
  if (asked.spacing.size() != 3) return bad_use("--spacing", "needs one number, or three: one per grid axis");
  for (int c = 0; c < 3; ++c) {
    const std::size_t u = static_cast<std::size_t>(c);
    asked.grid.spacing[c] = asked.spacing[u];
    asked.grid.rotation_deg[c] = asked.rotation_deg[u];
    asked.grid.offset[c] = asked.offset[u];
  }
  return check_scan(asked.grid, asked.scan);
}

// Every joint angle that --angle takes, with its range and its default in the standing pose, degrees.
std::string angles_for_help() {
  std::string text;
  for (const PoseAngle& angle : pose_angles)
    text += fmt::format("{}{}_left_{} {:g} to {:g}{}", text.empty() ? "" : ", ", angle.joint, angle.motion,
                        angle.least, angle.most,
                        angle.standing == 0 ? "" : fmt::format(" (standing: {:g})", angle.standing));
  return text;
}

// NAME and .nii.gz of a path like folder/NAME.nii.gz
Result<std::pair<fs::path, std::string>> split(const std::string& path) {
  const NamedFormat named = format_of(path, &VolumeFormat::written);
  if (!named.format)
    return bad_use(path, "names no volume; end it in " + endings_in_words(&VolumeFormat::written));
  return std::pair{fs::path(path.substr(0, path.size() - named.ending.size())),
                   path.substr(path.size() - named.ending.size())};
}

InertiaTable exact_table(const Phantom& phantom, const PhantomAsked& asked) {
  InertiaSource source;
  source.volume = fs::path(asked.output).filename();
  source.quantity = "the phantom's solids, integrated exactly (no voxels)";
  source.density_curve = asked.body.density_curve;
  source.density_source = density_curve(asked.body.density_curve).value().source;
  source.sex = asked.body.child ? "" : asked.sex;
  source.pose = asked.angles.empty() ? "standing" : "as requested";
  source.cuts = "deleva1996", source.frames = "joints";
  return make_table(std::move(source), rows_of_parts(phantom.exact, phantom.volume, phantom.landmarks));
}

struct Written {
  std::string volume, labels, table, csv, landmarks;
};

// The files to write, after checking that they can be written.
Result<Written> names_of(const std::string& output) {
  const auto name = split(output);
  if (!name) return tl::unexpected(name.error());
  const std::string stem = fs::absolute(name->first).string();
  Written files{stem + name->second, stem + "_labels" + name->second, stem + "_table.json",
                stem + "_table.csv", stem + "_landmarks.json"};
  for (const std::string& path :
       {files.volume, files.labels, names_file(files.labels), files.table, files.csv, files.landmarks})
    if (auto fine = check_writable(path); !fine) return tl::unexpected(fine.error());
  return files;
}

Result<void> write_all(const Written& files, const Phantom& phantom, const Scan& scan,
                       const InertiaTable& table) {
  for (const std::string& path : {files.table, files.csv})
    if (auto done = write_whole(path, [&](const fs::path& p) { return write_table(p, table); }); !done)
      return done;
  if (auto done = write_whole(
          files.landmarks, [&](const fs::path& p) { return write_landmarks(p.string(), phantom.landmarks); });
      !done)
    return done;
  if (auto done = write_label_files(files.labels, scan.labels); !done) return done;
  // the volume is written last: if it exists, so do the others
  return write_whole(files.volume, [&](const fs::path& p) { return write_volume(p.string(), scan.grey); });
}

void print(const Phantom& phantom, const Grid& grid, const Written& files) {
  fmt::print("Body of {:.2f} kg and {:.3f} m, made of {} solids, on {} x {} x {} voxels\n",
             phantom.whole.mass, phantom.landmarks.at("vertex").point.z() * 1e-3, phantom.solids.size(),
             grid.size[0], grid.size[1], grid.size[2]);
  for (std::size_t label = 1; label < parts.size(); ++label)
    fmt::print("{:<18} {:>8.4f} kg {:>6.2f} %\n", parts[label].name, phantom.exact[label].mass,
               100 * phantom.exact[label].mass / phantom.whole.mass);
  for (const std::string& path : {files.volume, files.labels, files.table, files.csv, files.landmarks})
    fmt::print("{}\n", path);
}

constexpr std::array walk_endings{".trc", "_grf.mot", "_moments.sto"};

/// Writes the walk's markers, ground forces and joint moments.
Result<void> write_walk(const std::string& stem, const Phantom& phantom, const Command& command) {
  PartInertials inertials;
  for (std::size_t label = 1; label < parts.size(); ++label)
    inertials[std::string(parts[label].name)] = phantom.exact[label];
  const auto skeleton = build_skeleton(inertials, phantom.landmarks, {.leap = std::nullopt});
  if (!skeleton) return tl::unexpected(skeleton.error());
  const auto markers = walk_markers(skeleton->scene, phantom.landmarks);
  if (!markers) return tl::unexpected(markers.error());
  const auto walk = sample_walk(skeleton->scene, *markers, standing_soles(phantom.landmarks));
  if (!walk) return tl::unexpected(walk.error());
  for (const std::string& warning : walk->warnings) command.warn(warning);
  const auto system = compile(skeleton->scene);
  if (!system) return tl::unexpected(system.error());
  TrcFile trc;
  trc.motion = in_opensim_axes(walk->markers);
  const auto text = trc_text(trc, stem + ".trc");
  if (!text) return tl::unexpected(text.error());
  if (auto done = write_whole(stem + ".trc", *text); !done) return done;
  for (const auto& [ending, table] : {std::pair{"_grf.mot", force_table_of(walk->loads)},
                                      std::pair{"_moments.sto", effort_table_of(*system, walk->efforts)}})
    if (auto done =
            write_whole(stem + ending, [&](const fs::path& p) { return write_motion_table(table, p); });
        !done)
      return done;
  return {};
}

Result<nlohmann::json> work(PhantomAsked asked, const Command& command) {
  if (const auto settled = settle(asked); !settled) return tl::unexpected(settled.error());
  const auto files = names_of(asked.output);
  if (!files) return tl::unexpected(files.error());
  if (!asked.walk.empty())
    for (const char* ending : walk_endings)
      if (auto fine = check_writable(asked.walk + ending); !fine) return tl::unexpected(fine.error());
  const auto phantom = build_phantom(asked.body);
  if (!phantom) return tl::unexpected(phantom.error());
  asked.scan.threads = command.threads;
  const Grid grid = phantom_grid(*phantom, asked.grid, asked.scan.table);
  if (auto fits = admit_memory(
          "--spacing", fmt::format("a grid of {} x {} x {} voxels", grid.size[0], grid.size[1], grid.size[2]),
          bytes_of_scan(grid, asked.scan));
      !fits)
    return tl::unexpected(fits.error());
  const Scan scan = voxelise(*phantom, grid, asked.scan);
  const InertiaTable table = exact_table(*phantom, asked);
  if (auto written = write_all(*files, *phantom, scan, table); !written)
    return tl::unexpected(written.error());
  if (!asked.walk.empty())
    if (auto written = write_walk(asked.walk, *phantom, command); !written)
      return tl::unexpected(written.error());
  if (!command.json) {
    print(*phantom, grid, *files);
    if (!asked.walk.empty())
      for (const char* ending : walk_endings) fmt::print("{}{}\n", asked.walk, ending);
  }
  nlohmann::json overlap = nlohmann::json::object();
  for (std::size_t label = 1; label < parts.size(); ++label) {
    const double share = phantom->overlap[label];
    if (share > 0) overlap[std::string(parts[label].name)] = share;
    // skin and fat may be compressed; more is a limb inside another
    if (constexpr double pressed = 0.25; share > pressed)
      command.warn(
          fmt::format("{:.0f} % of {} lies within another limb or the trunk, which no real body allows; "
                      "choose other angles for this body",
                      100 * share, parts[label].name));
  }
  return nlohmann::json{{"volume", files->volume}, {"labels", files->labels},
                        {"table", files->table},   {"landmarks", files->landmarks},
                        {"size", grid.size},       {"mass_kg", phantom->whole.mass},
                        {"girth", phantom->girth}, {"overlap", overlap}};
}

// Refuses negative seeds: -3 would wrap round to a large number.
std::string no_minus(const std::string& text) {
  return text.starts_with('-') ? "'" + text + "' is not a seed; give a whole number, 0 or more" : "";
}

void add_body_flags(CLI::App& verb, PhantomAsked& asked) {
  add_shared(verb, flags::sex, asked.sex)->capture_default_str();
  verb.add_flag("--child", asked.body.child, "Use the proportions of a six-year-old child");
  add_shared(verb, flags::stature, asked.body.stature_m, " (default: the mean of de Leva's sample)");
  add_shared(verb, flags::mass, asked.body.mass_kg,
             " (default: the mean of de Leva's sample, scaled by stature cubed)");
  verb.add_option("--angle", asked.angles,
                  "Joint angle in degrees, e.g. knee_left_flexion=30; may be repeated. Right joints take "
                  "the same angles: " +
                      angles_for_help())
      ->type_name("NAME=DEGREES")
      ->allow_extra_args(false);
  verb.add_option("--variation", asked.body.variation,
                  "Seed of a random body: varies lengths and thicknesses of segments and bones, and the way "
                  "the body stands")
      ->check(no_minus);
  verb.add_option("--metal-hip", asked.body.metal_hip, "Make femoral head and socket of this hip of metal")
      ->check(one_of({"left", "right"}));
  add_shared(verb, flags::density_curve, asked.body.density_curve)->capture_default_str();
  group_options(verb, "Body",
                {"--sex", "--child", "--stature", "--mass", "--angle", "--variation", "--metal-hip",
                 "--density-curve"});
}

void add_scanner_flags(CLI::App& verb, PhantomAsked& asked) {
  verb.add_option("--spacing", asked.spacing, "Voxel spacing, mm: one number, or one per axis")
      ->expected(1, 3)
      ->check(number_within(0.2, 50.0))
      ->capture_default_str();
  verb.add_option("--rotation-deg", asked.rotation_deg,
                  "Rotation of the grid about patient x, then y, then z, degrees")
      ->expected(3)
      ->check(number_within(-180.0, 180.0));
  verb.add_option("--tilt-deg", asked.grid.tilt_deg, "Gantry tilt, which shears the grid, degrees")
      ->check(number_within(-45.0, 45.0));
  verb.add_option("--offset", asked.offset, "Shift of the grid along its axes, in voxels")
      ->expected(3)
      ->check(number_within(-1.0, 1.0));
  verb.add_option("--margin", asked.grid.margin, "Air around the body, mm")
      ->check(number_within(0.0, 500.0))
      ->capture_default_str();
  verb.add_option(
          "--crop", asked.crop,
          "Scan only this box: x from and to, y from and to, z from and to, in the patient frame (LPS), mm")
      ->expected(6);
  verb.add_option("--field-of-view", asked.scan.field_of_view,
                  "Diameter of the field of view in each slice, mm (default: everything)")
      ->check(number_within(0.0, 2000.0));
  verb.add_flag("--partial-volume", asked.scan.partial_volume,
                "Give each voxel the mean over its box (default: the value at its centre)");
  verb.add_option("--blur", asked.scan.blur_mm, "Standard deviation of the scanner's blur, mm")
      ->check(number_within(0.0, 20.0));
  verb.add_option("--noise", asked.scan.noise_hu, "Standard deviation of the noise, HU")
      ->check(number_within(0.0, 1000.0));
  verb.add_option("--seed", asked.scan.seed, "Seed of the noise; the same seed gives the same bytes")
      ->check(no_minus)
      ->capture_default_str();
  verb.add_option("--streaks", asked.scan.streaks_hu, "Strength of the streaks at the metal's side, HU")
      ->check(number_within(0.0, 3000.0));
  verb.add_flag("--couch", asked.scan.table, "Lay the body on the scanner's curved couch");
  verb.add_flag("--blanket", asked.scan.blanket, "Lay a thick blanket over the body");
  group_options(
      verb, "Grid",
      {"--spacing", "--rotation-deg", "--tilt-deg", "--offset", "--margin", "--crop", "--field-of-view"});
  group_options(verb, "Scanner",
                {"--partial-volume", "--blur", "--noise", "--seed", "--streaks", "--couch", "--blanket"});
}

}  // namespace

void add_phantom(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("phantom", "Write the sample body as a scan, with its exact inertia table");
  auto asked = std::make_shared<PhantomAsked>();
  add_output(*verb, asked->output, "FILE", "Volume to write: .nii.gz, .nii, .nrrd or .mha")->required();
  verb->add_option(
          "--walk", asked->walk,
          "Also write a made-up motion capture of the body walking: STEM.trc (markers), STEM_grf.mot "
          "(ground forces) and STEM_moments.sto (the exact joint moments)")
      ->type_name("STEM");
  add_body_flags(*verb, *asked);
  add_scanner_flags(*verb, *asked);
  verb->callback([&command, asked, verb] {
    asked->seed_chosen = verb->count("--seed") > 0;
    asked->sex_chosen = verb->count("--sex") > 0;
    command.work = [asked](const Command& chosen) -> Result<nlohmann::json> { return work(*asked, chosen); };
  });
}

}  // namespace borelli
