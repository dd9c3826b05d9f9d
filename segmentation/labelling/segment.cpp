#include "segmentation/labelling/segment.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "process/memory.hpp"
#include "segmentation/body/anatomy.hpp"
#include "segmentation/body/body_mask.hpp"
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
#include "segmentation/labelling/landmark_seeds.hpp"
#include "segmentation/labelling/part_findings.hpp"
#include "segmentation/labelling/second_opinion.hpp"
#include "segmentation/labelling/soft_tissue.hpp"
#include "segmentation/labelling/unparted_limbs.hpp"
#include "segmentation/proposal/proposal.hpp"
#include "segmentation/proposal/walls.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Labels on the scan's own voxels. At the skin the voxel's own value decides whether it is body, in hollows
// the work grid's mask. The part follows from the flesh's owner on the work grid and the planes at the
// voxel's centre. Classes override both.
LabelMap label_voxels(const GreyVolume& volume, const Anatomy& a, const Volume<std::uint8_t>& owner,
                      const PartPlanes& planes, const ClassParts* classes, const AbsentParts& absent,
                      int threads) {
  LabelMap map;
  map.grid = volume.grid;
  map.voxels.assign(volume.grid.count(), 0);
  for (const Part& part : parts) map.names.emplace_back(part.name);
  const auto& g = volume.grid;
  const double step = a.step();
  using Place = std::array<std::int64_t, 3>;
  const auto place_at_work = [&](std::int64_t i, std::int64_t j, std::int64_t k) -> Place {
    const Vector3d index = (g.point(i, j, k) - a.grid().origin) / step;
    return {nearest_whole(index[0]), nearest_whole(index[1]), nearest_whole(index[2])};
  };
  // if the scan's axes are the patient's, each scan index maps to one work-grid index: computed once
  const bool straight = g.axes.isDiagonal(0);
  std::array<std::vector<std::int64_t>, 3> at_work;
  for (std::size_t c = 0; straight && c < 3; ++c)
    for (std::int64_t n = 0; n < g.size[c]; ++n)
      at_work[c].push_back(place_at_work(c == 0 ? n : 0, c == 1 ? n : 0, c == 2 ? n : 0)[c]);
  in_turns(g.size[2], threads, [&](std::int64_t k0, std::int64_t k1) {
    for (std::int64_t k = k0; k < k1; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const auto [wi, wj, wk] = straight ? Place{at_work[0][static_cast<std::size_t>(i)],
                                                     at_work[1][static_cast<std::size_t>(j)],
                                                     at_work[2][static_cast<std::size_t>(k)]}
                                             : place_at_work(i, j, k);
          const bool held = a.grid().holds(wi, wj, wk);
          const std::size_t w = held ? a.grid().offset(wi, wj, wk) : 0;
          if (const auto told = classes ? classes->place(g.offset(i, j, k)) : ClassParts::Place::open;
              told != ClassParts::Place::open) {
            if (told == ClassParts::Place::body)
              map.at(i, j, k) = static_cast<std::uint8_t>(
                  classes->part(g.offset(i, j, k), held ? owner.voxels[w] : 0, g.point(i, j, k), planes));
            continue;
          }
          if (!held) continue;
          if (!owner.voxels[w]) continue;
          const bool in_mask = a.body.voxels[w] != 0;
          const bool dense_there = a.scan.hu.voxels[w] > skin_edge_hu;
          const std::size_t o = g.offset(i, j, k);
          const bool dense = hu_of(volume.voxels[o], volume.quantity) > skin_edge_hu;
          // Count a dense voxel unless it belongs to a removed object (table, blanket). Count air in hollows
          // and deep inside. (A voxel that is body only because of a class does not make its neighbours a
          // hollow.)
          const bool hollow = !dense_there && !(classes && classes->at_work(w));
          const bool inside = dense ? in_mask || !dense_there
                                    : in_mask && (hollow || a.depth[w] > 2 * static_cast<float>(step));
          if (inside)
            map.voxels[o] = static_cast<std::uint8_t>(planes.part(owner.voxels[w], g.point(i, j, k)));
        }
  });
  leave_out(absent, map.voxels);
  return map;
}

using Progress = std::function<void(double, std::string_view)>;

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
  bool by_hand = false;
  auto bones = label_bones(a, trunk, limbs, PartPlanes(out.landmarks));
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
    by_hand = std::any_of(bones.voxels.begin(), bones.voxels.end(), [](std::uint8_t v) { return v != 0; });
  } else if (options.convention == Convention::bone) {
    part_bones_at_joints(a, out.landmarks, trunk.scale, bones);
    part_axial_bones(a, trunk, out.landmarks, bones);
  }
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
  else if (trunk.empty() && !classes)
    out.warnings.push_back({WarningKind::body, Severity::fault,
                            "no part was labelled: the scan shows neither both hips nor both shoulders, nor "
                            "two legs from mid-thigh to the feet, nor a head"});
  warn_of_lone_limbs(trunk, out);
  return out;
}

bool has_both(const Trunk& trunk) {
  return trunk.hip[0] && trunk.hip[1] && trunk.shoulder[0] && trunk.shoulder[1];
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

// How a volume is viewed: a body turned in the scanner along its own axes, and one of unusual size scaled to
// an adult's. Directions and lengths of bones, gaps and flesh are tuned to an adult who lies straight.
struct View {
  double size = 1;                                     // of the body relative to an adult
  Eigen::Matrix3d body = Eigen::Matrix3d::Identity();  // its left, back and up, in the patient frame
  double turn() const { return Eigen::AngleAxisd(body).angle(); }

  Grid seen(Grid grid) const {
    grid.axes = body.transpose() * grid.axes / size;
    grid.origin = body.transpose() * grid.origin / size;
    return grid;
  }
  Landmarks seen(Landmarks landmarks) const {
    return moved(std::move(landmarks), body.transpose(), 1 / size);
  }
  Landmarks unseen(Landmarks landmarks) const { return moved(std::move(landmarks), body, size); }

 private:
  static Landmarks moved(Landmarks landmarks, const Eigen::Matrix3d& turn, double factor) {
    for (auto& [name, landmark] : landmarks) {
      landmark.point = factor * (turn * landmark.point);
      landmark.deviation *= factor, landmark.radius *= factor;
    }
    return landmarks;
  }
};

// a body turned by more is viewed along its own axes (radians); hips and shoulders of straight bodies are up
// to about 3 degrees off
constexpr double straight = 6 * EIGEN_PI / 180;

Eigen::Matrix3d axes_of(const Vector3d& left, const Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.col(2) = up.normalized();
  axes.col(0) = (left - left.dot(axes.col(2)) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

// the body's own axes from hips and shoulders
Eigen::Matrix3d axes_of(const Trunk& trunk) {
  const auto across = [](const auto& pair) { return Vector3d(pair[0]->centre - pair[1]->centre); };
  const auto middle = [](const auto& pair) { return Vector3d(0.5 * (pair[0]->centre + pair[1]->centre)); };
  const Vector3d hips = across(trunk.hip), shoulders = across(trunk.shoulder);
  return axes_of(hips.normalized() + shoulders.normalized(), middle(trunk.shoulder) - middle(trunk.hip));
}

// The same without hips and shoulders, from the body's shape: up along the centres of its sections, left
// along their longer axis.
Eigen::Matrix3d axes_of_form(const Anatomy& a) {
  const auto& g = a.grid();
  double count = 0;
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix2d across = Eigen::Matrix2d::Zero();  // second moments of all sections about their centres
  std::vector<std::pair<Vector3d, double>> sections;
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    double n = 0;
    Vector3d first = Vector3d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!a.body.at(i, j, k)) continue;
        const Vector3d p = g.point(i, j, k);
        first += p, ++n;
        second += p.head<2>() * p.head<2>().transpose();
      }
    if (n == 0) continue;
    first /= n;
    across += second - n * first.head<2>() * first.head<2>().transpose();
    sections.emplace_back(first, n);
    sum += n * first, count += n;
  }
  if (count == 0) return Eigen::Matrix3d::Identity();
  const Vector3d centre = sum / count;
  Eigen::Vector2d rises = Eigen::Vector2d::Zero();
  double heights = 0;
  for (const auto& [c, n] : sections) {
    const double z = c[2] - centre[2];
    rises += n * z * (c - centre).head<2>();
    heights += n * z * z;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(across);
  Vector3d left(solver.eigenvectors()(0, 1), solver.eigenvectors()(1, 1), 0);
  constexpr double round = 1.3;  // ratio of second moments; below it no axis is longer
  if (solver.eigenvalues()[1] < round * solver.eigenvalues()[0]) left = Vector3d::UnitX();
  if (left[0] < 0) left = -left;
  // the sections of a short piece do not determine the up axis
  constexpr double long_enough = 500;  // mm
  const bool tall = a.step() * static_cast<double>(sections.size()) > long_enough;
  return axes_of(
      left, tall && heights > 0 ? Vector3d(rises[0] / heights, rises[1] / heights, 1) : Vector3d::UnitZ());
}

// The parts found in a view. Empty unless both hips and both shoulders are those of a straight body of usual
// size.
std::optional<Segmentation> parts_in_view(const GreyVolume& volume, const View& view,
                                          const SegmentOptions& options, const Progress& progress) {
  const GreyVolume usual{view.seen(volume.grid), volume.voxels, volume.quantity};
  Anatomy a = look(usual, options.step / view.size, options.threads);
  a.size = view.size;
  if (!has_body(a) || !ask_forest(a, options.forest)) return std::nullopt;
  const Trunk trunk = find_trunk(a, options.absent);
  constexpr double least = 0.75, most = 1.25;  // within these no other size fits much better
  if (!has_both(trunk) || trunk.scale < least || trunk.scale > most) return std::nullopt;
  if (View{1, axes_of(trunk)}.turn() > 2 * straight) return std::nullopt;
  SegmentOptions as_usual = options;
  as_usual.step /= view.size;
  as_usual.given = view.seen(options.given);
  Segmentation out = parts_of(usual, a, trunk, nullptr, as_usual, progress);
  out.labels.grid = volume.grid;
  out.landmarks = view.unseen(std::move(out.landmarks));
  for (PartFinding& part : out.part) part.volume *= view.size * view.size * view.size;
  for (const auto& [name, landmark] : options.given) out.landmarks[name] = landmark;
  if (view.turn() > straight)
    out.warnings.push_back({WarningKind::scan, Severity::note,
                            fmt::format("the body lies rotated by {:.0f} degrees in the scanner; the parts "
                                        "were found along its own axes",
                                        view.turn() * 180 / EIGEN_PI)});
  return out;
}

// Further views, given what an adult's directions and lengths found. With hips and shoulders: along the found
// axes and at the found size if these are unusual. Else along the axes of the body's shape, and at the sizes
// of a child and a giant if the scan may hold a whole trunk of that size.
std::vector<View> other_views(const Anatomy& a, const Trunk& trunk) {
  constexpr double small = 0.82, large = 1.14;
  if (has_both(trunk)) {
    View view;
    if (trunk.scale < small || trunk.scale > large) view.size = trunk.scale;
    if (const View own{1, axes_of(trunk)}; own.turn() > straight) view.body = own.body;
    if (view.size == 1 && view.turn() == 0) return {};
    return {view};
  }
  std::vector<View> views;
  const View form{1, axes_of_form(a)};
  const bool turned = form.turn() > straight;
  if (turned) views.push_back(form);
  if (trunk.shoulder[0]) return views;  // confirmed by the lungs: only the hips are out of view
  constexpr double child = 0.68, giant = 1.22, trunk_and_more = 800;  // mm, an adult from knee to chin
  const double height = a.step() * static_cast<double>(a.grid().size[2]);
  for (const double size : {child, giant}) {
    if (height <= trunk_and_more * size) continue;
    views.push_back({size});
    if (turned) views.push_back({size, form.body});
  }
  return views;
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
  Segmentation found = parts_of(volume, a, trunk, classes, options, progress);
  warn_of_parts(found);
  return found;
}

// Parts of a body whose header has a wrong orientation, found in the body's own directions. Empty if these
// are no better.
std::optional<Segmentation> parts_turned_over(const GreyVolume& volume, const Eigen::Matrix3d& axes,
                                              const SegmentOptions& options, const Progress& progress) {
  const View view{1, axes};
  const GreyVolume turned{view.seen(volume.grid), volume.voxels, volume.quantity};
  Anatomy a = look(turned, options.step, options.threads);
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
    finding.confidence = std::min(finding.confidence, unsure);
    finding.note += (finding.note.empty() ? "" : "; ") +
                    std::string("left or right uncertain: the header contradicts the body");
  }
  return out;
}

/// Share of the voxels on the scan's outer faces that are 0.
double zeros_at_border(const GreyVolume& volume) {
  const auto& size = volume.grid.size;
  std::int64_t zeros = 0, all = 0;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j) {
      const bool whole_row = k == 0 || k == size[2] - 1 || j == 0 || j == size[1] - 1;
      for (std::int64_t i = 0; i < size[0]; i += whole_row ? 1 : std::max<std::int64_t>(size[0] - 1, 1)) {
        zeros += volume.at(i, j, k) == 0;
        ++all;
      }
    }
  return all > 0 ? double(zeros) / double(all) : 0;
}

}  // namespace

Result<Segmentation> segment(const GreyVolume& volume, const SegmentOptions& options) {
  if (volume.quantity != Quantity::hu && volume.quantity != Quantity::density_kgm3)
    return failure("segmentation",
                   volume.quantity == Quantity::labels
                       ? "this volume is a label map, and parts are found in CT numbers or densities; give "
                         "its scan as the volume, and this file with --labels"
                       : "this volume contains magnetic resonance signal, and parts are found in CT numbers "
                         "or densities; give a label map of its parts with --labels, or state what it holds "
                         "(--quantity hu or density_kgm3)");
  if (volume.grid.count() == 0 || volume.voxels.size() != volume.grid.count())
    return failure("segmentation", "the volume contains no voxels");
  if (volume.quantity == Quantity::hu && *std::min_element(volume.voxels.begin(), volume.voxels.end()) >= 0)
    return failure("segmentation",
                   "these CT numbers show neither air nor fat, since none is below 0; subtract 1024 if it "
                   "was added, or state what they are (--quantity density_kgm3)");
  // tissue and air are noisy: few voxels of an outermost slice through a body share one exact value
  constexpr double most_zeros = 0.05;
  if (const double zeros = zeros_at_border(volume); volume.quantity == Quantity::hu && zeros > most_zeros)
    return failure(
        "segmentation",
        fmt::format("{:.2g} % of the scan's outermost voxels are exactly 0 HU: the picture was padded there "
                    "with the value of water, which would be weighed as body; pad it with -1000, or crop it",
                    100 * zeros));
  if (!(options.step >= finest_step && options.step <= coarsest_step))
    return bad_use("segmentation", fmt::format("the work grid's spacing is {:.6g} mm; choose {:g} to {:g} mm",
                                               options.step, finest_step, coarsest_step));
  constexpr double largest_scan = 5000;  // mm: the work grid spans the whole scan
  const Eigen::Array3d extent =
      volume.grid.spacing().array() *
      Eigen::Map<const Eigen::Array<std::int64_t, 3, 1>>(volume.grid.size.data()).cast<double>();
  if (extent.maxCoeff() > largest_scan)
    return failure(
        "segmentation",
        fmt::format(
            "the scan measures {:.3g} x {:.3g} x {:.3g} m, more than any body; check the unit of its voxels",
            extent[0] / 1e3, extent[1] / 1e3, extent[2] / 1e3));
  const auto progress = [&](double share, std::string_view what) {
    if (options.progress) options.progress(share, what);
  };

  for (const auto& [name, landmark] : options.given) {
    constexpr double beyond = 100;  // mm: a joint may lie somewhat beyond the scan's end
    const Vector3d index = volume.grid.index(landmark.point);
    Vector3d inside;
    for (int c = 0; c < 3; ++c)
      inside[c] =
          std::clamp(index[c], 0.0, static_cast<double>(volume.grid.size[static_cast<std::size_t>(c)] - 1));
    if (const double off = (volume.grid.point(inside) - landmark.point).norm(); off > beyond)
      return bad_use("landmarks", fmt::format("{} lies {:.0f} mm outside the scan; check that its "
                                              "coordinates are in mm, and in LPS or RAS as its file says",
                                              name, off));
  }

  if (auto fine = check_given(options.absent, options.given); !fine) return tl::unexpected(fine.error());

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
  Anatomy a = look(volume, grid, options.threads);
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
