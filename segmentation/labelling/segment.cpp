#include "segmentation/labelling/segment.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "process/memory.hpp"
#include "segmentation/body/anatomy.hpp"
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/joints/column_levels.hpp"
#include "segmentation/joints/frame_points.hpp"
#include "segmentation/joints/half_turns.hpp"
#include "segmentation/joints/hip_regressions.hpp"
#include "segmentation/joints/joint_centres.hpp"
#include "segmentation/joints/limb_tips.hpp"
#include "segmentation/joints/lone_heads.hpp"
#include "segmentation/joints/lone_parts.hpp"
#include "segmentation/joints/missing_elbows.hpp"
#include "segmentation/joints/one_side.hpp"
#include "segmentation/joints/trunk_landmarks.hpp"
#include "segmentation/labelling/axial_bones.hpp"
#include "segmentation/labelling/body_doubts.hpp"
#include "segmentation/labelling/bones.hpp"
#include "segmentation/labelling/bones_at_joints.hpp"
#include "segmentation/labelling/class_parts.hpp"
#include "segmentation/labelling/forest_parts.hpp"
#include "segmentation/labelling/landmark_seeds.hpp"
#include "segmentation/labelling/part_findings.hpp"
#include "segmentation/labelling/scan_check.hpp"
#include "segmentation/labelling/second_opinion.hpp"
#include "segmentation/labelling/soft_tissue.hpp"
#include "segmentation/labelling/unparted_limbs.hpp"
#include "segmentation/labelling/views.hpp"
#include "segmentation/labelling/voxel_labels.hpp"
#include "segmentation/proposal/proposal.hpp"
#include "segmentation/proposal/walls.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

using Progress = std::function<void(double, std::string_view)>;

// The bones of each part, from which the parts grow.
struct SeedBones {
  Volume<std::uint8_t> bones;
  bool by_hand = false;  // from given landmarks alone
  std::optional<ForestParts> by_forest = std::nullopt;
};

// Adds the joints that the classes show, and warnings about them, to `out`.
SeedBones seed_bones(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, ClassParts* classes,
                     const SegmentOptions& options, Segmentation& out) {
  SeedBones seeds{label_bones(a, trunk, limbs, PartPlanes(out.landmarks)), false};
  auto& bones = seeds.bones;
  if (classes) {
    if (options.convention == Convention::bone) part_axial_bones(a, trunk, out.landmarks, bones);
    bones = classes->seeds(a, bones, PartPlanes(out.landmarks), out.landmarks);
    std::vector<std::string> elsewhere;
    classes->find_joints(a, bones, out.landmarks, elsewhere);
    add_warnings(out.warnings, WarningKind::labels, Severity::note, elsewhere);
    add_warnings(out.warnings, WarningKind::labels, Severity::note, options.classes->warnings);
    add_warnings(out.warnings, WarningKind::labels, Severity::doubt, classes->warnings());
    put_given(options.given, out.landmarks);
  } else if (trunk.empty() && !options.given.empty()) {
    bones = seeds_by_landmarks(a, out.landmarks);
    seeds.by_hand =
        std::any_of(bones.voxels.begin(), bones.voxels.end(), [](std::uint8_t v) { return v != 0; });
  } else if (trunk.empty() && a.proposal) {
    seeds.by_forest = parts_by_forest(a, trunk);
    bones = seeds.by_forest->bones;
    out.landmarks.insert(seeds.by_forest->landmarks.begin(), seeds.by_forest->landmarks.end());
    if (seeds.by_forest->empty()) seeds.by_forest.reset();
  } else if (options.convention == Convention::bone) {
    part_bones_at_joints(a, out.landmarks, trunk.scale, bones);
    part_axial_bones(a, trunk, out.landmarks, bones);
  }
  if (a.proposal && !classes && !seeds.by_hand && !trunk.empty())
    add_rootless_limbs(a, trunk, bones, out.landmarks);
  return seeds;
}

// Parts and landmarks of a body whose trunk is known. `options`: for this volume; lengths are scaled if a
// body of unusual size is viewed at an adult's size.
Segmentation parts_of(const GreyVolume& volume, Anatomy& a, const Trunk& of_body, ClassParts* classes,
                      const SegmentOptions& options, const Progress& progress) {
  progress(0.5, "following the limbs");
  if (a.proposal && !of_body.empty() && heads_agree(*a.proposal, of_body)) put_walls(a);
  // in parallel, because one thread traces the limbs
  auto lean = std::async(aside(a.threads), [&] { return lean_flesh(a); });
  Trunk trunk = of_body;
  if (!classes && options.given.empty() && trunk.empty()) find_lone_parts(a, trunk);
  const Limbs limbs = trace_limbs(a, trunk);
  Segmentation out;
  find_limb_landmarks(a, trunk, limbs, out.landmarks);
  find_trunk_landmarks(a, trunk, limbs, out.landmarks);
  doubt_misfit_hips(out.landmarks);
  mirror_sides(trunk, limbs, out.landmarks);
  put_in_middle(trunk, out.landmarks);
  out.convention = options.convention;
  out.absent = options.absent;
  add_warnings(out.warnings, WarningKind::landmark, Severity::doubt,
               doubts_of_given(options.given, out.landmarks));
  put_given(options.given, out.landmarks);
  place_unseen_hips(out.landmarks, sides_without_leg(trunk));
  if (options.convention != Convention::deleva1996) {
    find_column_levels(a, trunk, out.landmarks);
    seat_spine_joints(options.convention, out.landmarks);
    put_given(options.given, out.landmarks);
  }

  progress(0.6, "separating the bones");
  const auto [bones, by_hand, by_forest] = seed_bones(a, trunk, limbs, classes, options, out);
  progress(0.7, "dividing the soft tissue");
  auto owner = label_soft_tissue(a, lean.get(), bones, options.step, options.convention);
  mirror_legs(a, trunk, limbs, owner);
  // with `bone` no plane separates the forearm at an elbow out of view
  if (options.convention != Convention::bone) place_missing_elbows(a, limbs, owner, trunk, out.landmarks);
  find_limb_tips(a, limbs, owner, trunk.scale, out.landmarks);
  put_given(options.given, out.landmarks);
  find_frame_points(a, trunk, owner, out.landmarks);
  mirror_sides(trunk, limbs, out.landmarks);
  put_given(options.given, out.landmarks);
  if (a.proposal) {
    doubt_joints_by_proposal(a, gone_parts(trunk), out.landmarks);
    put_given(options.given, out.landmarks);
  }
  place_unseen_hips(out.landmarks, sides_without_leg(trunk));  // pelvic tilt from the PSIS
  const PartPlanes planes(out.landmarks, options.convention);
  progress(0.9, "cutting at the joints");
  out.labels = label_voxels(volume, a, owner, planes, classes, options.absent, options.threads);
  judge_parts(a, owner, planes, gone_parts(trunk), out);
  if (limbs.arms_meet) doubt_hands_that_meet(out);
  doubt_head_under_arms(a, limbs, out);
  put_given(options.given, out.landmarks);
  if (!classes && !by_hand && trunk.hip[0] && !trunk.shoulder[0])
    doubt_what_holds_arms(a, owner, planes, std::max(trunk.hip[0]->centre[2], trunk.hip[1]->centre[2]), out);
  if (trunk.femur[0]) doubt_thighs_above_crotch(a, owner, out);
  if (trunk.brain) doubt_trunk_without_shoulders(out);
  if (!classes && !by_hand && trunk.shoulder[0]) doubt_trunk_without_hips(a, owner, planes, trunk.scale, out);
  if (!classes && !trunk.empty()) warn_of_flesh_without_part(a, owner, out);
  if (a.proposal && !by_hand && !trunk.empty()) doubt_by_proposal(*a.proposal, out);
  if (by_hand)
    out.warnings.push_back(
        {WarningKind::body, Severity::note,
         "the scan shows neither both hips nor both shoulders; the parts rely on the given landmarks alone"});
  else if (by_forest)
    doubt_forest_parts(*by_forest, out);
  else if (trunk.empty() && !classes)
    out.warnings.push_back(
        {WarningKind::body, Severity::fault,
         "no part was labelled: the scan shows neither both hips nor both shoulders, nor "
         "knees, a head or a piece of trunk that could be recognised; if it shows one leg, "
         "name the other one with --absent, e.g. --absent thigh_left"});
  warn_of_lone_limbs(trunk, out);
  return out;
}

bool has_body(const Anatomy& a) {
  return std::any_of(a.body.voxels.begin(), a.body.voxels.end(), [](std::uint8_t v) { return v != 0; });
}

// Asks the forest about a body, unless it is larger than any person. Errors: those of propose, which do not
// depend on the body.
Result<void> ask_forest(Anatomy& a, const Forest* forest) {
  constexpr double largest_person = 400e6;  // mm^3: more than 300 kg
  const auto voxels = static_cast<double>(std::count(a.body.voxels.begin(), a.body.voxels.end(), 1));
  if (voxels * a.grid().voxel_volume() > largest_person) return {};
  auto proposal = propose(a, forest);
  if (!proposal) return tl::unexpected(proposal.error());
  a.proposal = std::make_shared<const Proposal>(*std::move(proposal));
  return {};
}

// The same with the next likely pair of hips, if the iliac spines contradict the first pair and not that one.
Segmentation parts_about_likely_hips(const GreyVolume& volume, Anatomy& a, const Trunk& trunk,
                                     ClassParts* classes, const SegmentOptions& options,
                                     const Progress& progress) {
  Segmentation found = parts_of(volume, a, trunk, classes, options, progress);
  const auto hips_misfit = [](const Segmentation& s) {
    const auto hip = s.landmarks.find("hip_left");
    return hip != s.landmarks.end() && hip->second.source.ends_with(unlike_body);
  };
  if (classes || !options.given.empty() || !hips_misfit(found)) return found;
  const Trunk other = find_trunk(a, options.absent, trunk.hip);
  if (!other.hip[0] || !other.hip[1]) return found;
  a.wall.clear();
  Segmentation next = parts_of(volume, a, other, classes, options, progress);
  return !hips_misfit(next) && next.landmarks.contains("hip_left") ? next : found;
}

// The parts found in a view. Empty unless both hips and both shoulders are those of a straight body of usual
// size.
std::optional<Segmentation> parts_in_view(const GreyVolume& volume, const View& view,
                                          const SegmentOptions& options, const Progress& progress) {
  const GreyVolume usual{view.seen(volume.grid), volume.voxels, volume.quantity};
  Anatomy a = anatomy_of(usual, options.step / view.size, options.threads);
  a.size = view.size;
  if (!has_body(a) || !ask_forest(a, options.forest)) return std::nullopt;
  const Trunk trunk = find_trunk(a, options.absent);
  constexpr double least = 0.75, most = 1.25;  // within these no other size fits much better
  if (!has_both(trunk) || trunk.scale < least || trunk.scale > most) return std::nullopt;
  if (View{1, axes_of(trunk)}.turn() > 2 * straight_body) return std::nullopt;
  SegmentOptions as_usual = options;
  as_usual.step /= view.size;
  as_usual.given = view.seen(options.given);
  Segmentation out = parts_about_likely_hips(usual, a, trunk, nullptr, as_usual, progress);
  out.labels.grid = volume.grid;
  out.landmarks = view.unseen(std::move(out.landmarks));
  for (PartFinding& part : out.part) part.volume *= view.size * view.size * view.size;
  for (const auto& [name, landmark] : options.given) out.landmarks[name] = landmark;
  if (view.turn() > straight_body)
    out.warnings.push_back({WarningKind::scan, Severity::note,
                            fmt::format("the body lies rotated by {:.0f} degrees in the scanner; the parts "
                                        "were found along its own axes",
                                        view.turn() * 180 / EIGEN_PI)});
  return out;
}

// Parts of a body in the orientation of its header, with the turns and sizes of `other_views`.
Segmentation parts_as_it_lies(const GreyVolume& volume, Anatomy& a, const Trunk& trunk, ClassParts* classes,
                              const SegmentOptions& options, const Progress& progress) {
  if (!classes)  // classes need no other view
    for (const View& view : other_views(a, trunk))
      if (auto found = parts_in_view(volume, view, options, progress)) {
        warn_of_parts(*found);
        return *std::move(found);
      }
  // if hips or shoulders are other bones, try again without them: then the forest names the parts
  constexpr double too_much = 0.25;
  const bool may_err = !classes && options.given.empty() && a.proposal && !trunk.empty() && !has_both(trunk);
  Trunk without;
  without.lungs = trunk.lungs, without.absent = trunk.absent;
  const bool false_hips = may_err && hips_near_crests(a, trunk);
  Segmentation found =
      parts_about_likely_hips(volume, a, false_hips ? without : trunk, classes, options, progress);
  if (may_err && !false_hips && contradicted_share(*a.proposal, found.labels) > too_much) {
    a.wall.clear();
    found = parts_of(volume, a, without, classes, options, progress);
  }
  warn_of_parts(found);
  return found;
}

// Parts of a body whose header has a wrong orientation, found in the body's own directions. Empty if these
// are no better.
std::optional<Segmentation> parts_turned_over(const GreyVolume& volume, const Eigen::Matrix3d& axes,
                                              const SegmentOptions& options, const Progress& progress) {
  const View view{1, axes};
  const GreyVolume turned{view.seen(volume.grid), volume.voxels, volume.quantity};
  Anatomy a = anatomy_of(turned, options.step, options.threads);
  if (!ask_forest(a, options.forest)) return std::nullopt;
  const Trunk trunk = find_trunk(a, options.absent);
  // accept if no half turn remains, hips or shoulders are found, and both if the header is upside down
  if (half_turn(a, trunk) || !(trunk.hip[0] || trunk.shoulder[0]) || (axes(2, 2) < 0 && !has_both(trunk)))
    return std::nullopt;
  SegmentOptions own = options;
  own.given = view.seen(options.given);
  Segmentation out = parts_as_it_lies(turned, a, trunk, nullptr, own, progress);
  out.labels.grid = volume.grid;
  out.landmarks = view.unseen(std::move(out.landmarks));
  out.warnings.push_back({WarningKind::scan, Severity::doubt, words_of_half_turn(axes)});
  constexpr double unsure = 0.4;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartFinding& finding = out.part[n];
    if (finding.volume == 0 || !(parts[n].name.ends_with("_left") || parts[n].name.ends_with("_right")))
      continue;
    finding.doubt(unsure, "left or right uncertain: the header contradicts the body");
  }
  return out;
}

}  // namespace

Result<Segmentation> segment(const GreyVolume& volume, const SegmentOptions& options) {
  if (auto fine = check_scan(volume, options); !fine) return tl::unexpected(fine.error());
  const auto progress = [&](double share, std::string_view what) {
    if (options.progress) options.progress(share, what);
  };

  progress(0, "finding body and bones");
  const Grid grid = work_grid(volume, options.step, options.threads);
  // bytes of all volumes on the work grid, with the scan (3 bytes), and of the labels on the scan's own grid
  const double bytes = (bytes_at_work + 3.0) * static_cast<double>(grid.count()) +
                       (options.classes ? 2.0 : 1.0) * static_cast<double>(volume.grid.count());
  if (auto fits = admit_memory("segmentation",
                               fmt::format("a work grid of {} x {} x {} voxels of {:g} mm", grid.size[0],
                                           grid.size[1], grid.size[2], options.step),
                               bytes);
      !fits)
    return tl::unexpected(fits.error());
  Anatomy a = anatomy_of(volume, grid, options.threads);
  std::optional<ClassParts> classes;
  if (options.classes) {
    classes.emplace(*options.classes, volume.grid, a.grid(), options.threads);
    classes->mend(a, options.threads);
  }
  if (!has_body(a))
    return failure("segmentation",
                   "the volume contains no body: nothing in it is denser than air over more than a few "
                   "centimetres; check that it holds Hounsfield units");
  if (!classes) {
    progress(0.4, "identifying the limbs");
    if (auto asked = ask_forest(a, options.forest); !asked) return tl::unexpected(asked.error());
  }
  progress(0.45, "finding hips, shoulders and spine");
  const Trunk trunk = find_trunk(a, options.absent);
  std::optional<Segmentation> out;
  if (const auto own = classes ? std::nullopt : half_turn(a, trunk))
    out = parts_turned_over(volume, *own, options, progress);
  if (!out) out = parts_as_it_lies(volume, a, trunk, classes ? &*classes : nullptr, options, progress);
  for (const auto& [name, landmark] : options.given) out->given.push_back(name);
  warn_of_joints(volume.grid, *out);
  progress(1, "");
  return *std::move(out);
}

}  // namespace borelli
