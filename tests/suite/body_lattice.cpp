#include "tests/suite/body_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>

#include "tests/suite/labelled_body.hpp"

namespace borelli::suite {
namespace {

constexpr float followed = 300;  // longest path to the bones at a joint, mm

float smooth(float u) {
  u = std::clamp(u, 0.0F, 1.0F);
  return u * u * (3 - 2 * u);
}

std::uint16_t in_units(float share) { return static_cast<std::uint16_t>(std::lround(65535 * share)); }

struct Paths {
  std::vector<float> length;
  std::vector<std::uint8_t> nearest;
};

class Sharing {
 public:
  Sharing(const LabelledBody& body, std::vector<Shares>& out)
      : body_(body), bones_(bone_parts(body)), out_(out) {
    out_.assign(body.voxel.size(), Shares{});
  }

  void all() {
    by_height();
    const Paths torso = paths({"upper_trunk"}), pelvis = paths({"lower_trunk"});
    {
      const Paths head = paths({"head"}, [&](std::size_t n) { return !body_.is(n, 47, 48); });
      by_paths(torso, head, "neck", 200, {"head"});
    }
    const Paths upper_arm = paths({"upper_arm_left", "upper_arm_right"});
    by_paths(torso, upper_arm, "shoulder", 80, {"upper_arm", "forearm", "hand"});
    const Paths forearm = paths({"forearm_left", "forearm_right"});
    by_paths(upper_arm, forearm, "elbow", 60, {"forearm", "hand"});
    by_paths(forearm, paths({"hand_left", "hand_right"}), "wrist", 40, {"hand"});
    const Paths thigh = paths({"thigh_left", "thigh_right"});
    by_paths(pelvis, thigh, "hip", 100, {"thigh", "shank", "foot"});
    const Paths shank = paths({"shank_left", "shank_right"});
    by_paths(thigh, shank, "knee", 70, {"shank", "foot"});
    by_paths(shank, paths({"foot_left", "foot_right"}), "ankle", 50, {"foot"});
  }

 private:
  Paths paths(
      std::initializer_list<std::string_view> of,
      const std::function<bool(std::size_t)>& keep = [](std::size_t) { return true; }) const {
    std::vector<std::uint8_t> seed(bones_.size());
    for (std::size_t n = 0; n < seed.size(); ++n)
      for (const std::string_view name : of)
        if (bones_[n] == part_label(name) && keep(n)) seed[n] = bones_[n];
    Paths out;
    out.length = paths_through(body_, seed, followed, &out.nearest);
    return out;
  }

  void by_paths(const Paths& before, const Paths& behind, const std::string& joint, float width,
                std::initializer_list<std::string_view> chain) {
    const bool sided = joint != "neck";
    for (const std::string side : {"_left", "_right"}) {
      const std::size_t j = joint_index(sided ? joint + side : joint);
      std::array<bool, parts.size()> beyond{};
      for (const std::string_view stem : chain)
        beyond[static_cast<std::size_t>(part_label(sided ? std::string(stem) + side : std::string(stem)))] =
            true;
      for (std::size_t n = 0; n < out_.size(); ++n) {
        const float p = before.length[n], c = behind.length[n];
        float share = beyond[body_.owner[n]];
        if (p < no_tissue_path && c < no_tissue_path &&
            (!sided || parts[behind.nearest[n]].name.ends_with(side)))
          share = p + c > 0 ? smooth(0.5F + 0.5F * (p - c) / std::min(width, p + c)) : 0.5F;
        else if (p < no_tissue_path && c < no_tissue_path)
          share = 0;
        out_[n][j] = in_units(share);
      }
      if (!sided) return;
    }
  }

  void by_height() {
    const auto z = [&](const char* name) { return body_.landmarks.at(name).point.z(); };
    double crest = -1e9;
    for (std::size_t n = 0; n < out_.size(); ++n)
      if (body_.is(n, 41, 42)) crest = std::max(crest, body_.centre(n).z());
    const double middle = z("t12_l1"), high = z("xiphion") + 60;
    for (std::size_t n = 0; n < out_.size(); ++n) {
      const std::string_view owner = parts[body_.owner[n]].name;
      const bool arm =
          owner.starts_with("upper_arm") || owner.starts_with("forearm") || owner.starts_with("hand");
      const double at = body_.centre(n).z();
      const auto share = [&](double from, double to) {
        return in_units(smooth(float((at - from) / (to - from))));
      };
      out_[n][0] = arm ? 65535 : share(crest, middle + 10);
      out_[n][1] = arm ? 65535 : share(middle - 30, high);
    }
  }

  const LabelledBody& body_;
  std::vector<std::uint8_t> bones_;
  std::vector<Shares>& out_;
};

std::vector<float> lifts(const LabelledBody& body) {
  std::vector<std::uint8_t> skin(body.voxel.size());
  for (std::size_t n = 0; n < skin.size(); ++n) skin[n] = body.is(n, 122, 125);
  const std::vector<float> depth = paths_through(body, skin, 80);
  std::vector<float> out(skin.size());
  for (std::size_t n = 0; n < out.size(); ++n)
    out[n] =
        depth[n] < no_tissue_path ? smooth(float(body.off_bone[n]) / 30) * (1 - smooth(depth[n] / 60)) : 0;
  return out;
}

// For each of the eight voxels at a corner, the lowest number in its connected piece.
std::array<int, 8> pieces(const LabelledBody& body, const std::array<std::uint32_t, 8>& about) {
  std::array<int, 8> piece{0, 1, 2, 3, 4, 5, 6, 7};
  for (bool changed = true; changed;) {
    changed = false;
    for (int a = 0; a < 8; ++a)
      for (const int bit : {1, 2, 4}) {
        const int b = a ^ bit;
        const auto ua = static_cast<std::size_t>(a), ub = static_cast<std::size_t>(b);
        if (!about[ua] || !about[ub] || piece[ua] <= piece[ub]) continue;
        if (!may_touch(body.contact[about[ua] - 1], body.contact[about[ub] - 1])) continue;
        piece[ua] = piece[ub], changed = true;
      }
  }
  return piece;
}

void add_corner(const LabelledBody& body, const std::array<std::uint32_t, 8>& about,
                const Eigen::Vector3f& place, BodyLattice& out) {
  const std::array<int, 8> piece = pieces(body, about);
  for (int p = 0; p < 8; ++p) {
    std::array<double, n_joints> sum{};
    double count = 0, lift = 0;
    for (const bool bones : {true, false}) {
      for (std::size_t a = 0; a < 8; ++a) {
        if (!about[a] || piece[a] != p || (bones && !body.bone[about[a] - 1])) continue;
        for (std::size_t j = 0; j < n_joints; ++j) sum[j] += out.voxel_share[about[a] - 1][j];
        lift += bones ? 0 : out.voxel_lift[about[a] - 1], ++count;
      }
      if (count > 0) break;
    }
    if (count == 0) continue;
    Shares shares;
    for (std::size_t j = 0; j < n_joints; ++j) shares[j] = static_cast<std::uint16_t>(sum[j] / count + 0.5);
    const auto corner = static_cast<std::uint32_t>(out.rest.size());
    out.rest.push_back(place), out.share.push_back(shares), out.lift.push_back(float(lift / count));
    for (std::size_t a = 0; a < 8; ++a)
      if (about[a] && piece[a] == p) out.corners[about[a] - 1][7 - a] = corner;
  }
}

}  // namespace

BodyLattice lattice_of(const LabelledBody& body) {
  BodyLattice out;
  Sharing(body, out.voxel_share).all();
  out.voxel_lift = lifts(body);
  out.corners.resize(body.voxel.size());
  const Grid& g = body.grid;
  const auto number = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return g.holds(i, j, k) ? body.number[g.offset(i, j, k)] : 0U;
  };
  for (std::int64_t k = 0; k <= g.size[2]; ++k)
    for (std::int64_t j = 0; j <= g.size[1]; ++j)
      for (std::int64_t i = 0; i <= g.size[0]; ++i) {
        std::array<std::uint32_t, 8> about;
        std::uint32_t any = 0;
        for (std::size_t a = 0; a < 8; ++a)
          any |= about[a] = number(i - 1 + std::int64_t(a & 1), j - 1 + std::int64_t(a >> 1 & 1),
                                   k - 1 + std::int64_t(a >> 2));
        if (any) {
          const Eigen::Vector3d place =
              g.point(Eigen::Vector3d(double(i), double(j), double(k)).array() - 0.5);
          add_corner(body, about, place.cast<float>(), out);
        }
      }
  return out;
}

}  // namespace borelli::suite
