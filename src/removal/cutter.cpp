#include "removal/cutter.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "bone/cell_block.h"
#include "bone/cell_volume.h"
#include "bone/grids.h"
#include "removal/leaf_map.h"
#include "removal/sweep.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;
using Accessor = openvdb::FloatGrid::Accessor;

constexpr double kPi = 3.14159265358979323846;
constexpr int kLeafEdge = 8;
constexpr double kHalfLeafDiagonal = 6.0622;  // of 7 voxels along each axis, in voxels

/// A leaf with its values after the cut.
struct ChangedLeaf {
  Coord origin;
  std::array<float, FloatLeaf::SIZE> values;
};

Coord LeafOrigin(const Vec3& p_vox) {
  const auto down = [](double x) { return static_cast<int>(std::floor(x)) & ~(kLeafEdge - 1); };
  return {down(p_vox.x), down(p_vox.y), down(p_vox.z)};
}

}  // namespace

struct Cutter::State {
  State(Bone& the_bone, const DiscSaw& the_saw)
      : bone(the_bone),
        saw(the_saw),
        h(the_bone.voxel_mm()),
        region_h(the_bone.region_voxel_mm()),
        band_mm(static_cast<double>(the_bone.grids().phi->background())),
        phi(the_bone.grids().phi->tree()),
        region(the_bone.grids().region->constTree()) {}

  double Cut(const Pose& X_from, const Pose& X_to);
  bool FlanksMoved(const Pose& X) const;
  void FindLeavesAtRim(const DiscSweep& sweep, const Pose& X);
  void FindLeavesAtDisc(const DiscSweep& sweep, const Pose& X);
  void AddLeavesInBall(const Vec3& centre_W, double radius_mm);
  void CarveLeaf(const DiscSweep& sweep, const Pose& X, const Coord& origin);
  double MeasureLoss();
  double MeasureLossInBlock(const Coord& owner);
  void Commit();

  Bone& bone;
  DiscSaw saw;
  double h;
  double region_h;
  double band_mm;
  Accessor phi;
  openvdb::Int32Grid::ConstAccessor region;
  std::array<double, 256> removed_mm3{};
  std::optional<Pose> X_flanks;  // where the flats were last looked at

  // Kept between cuts for their memory.
  std::vector<Coord> candidates;
  LeafMap candidate_set;
  std::vector<ChangedLeaf> changed;
  std::size_t changed_count = 0;
  LeafMap changed_map;
  LeafMap owner_set;
};

Cutter::Cutter(Bone& bone, const DiscSaw& saw) : state_(std::make_unique<State>(bone, saw)) {}
Cutter::~Cutter() = default;
Cutter::Cutter(Cutter&&) noexcept = default;
Cutter& Cutter::operator=(Cutter&&) noexcept = default;

double Cutter::Cut(const Pose& X_from, const Pose& X_to) {
  return state_->Cut(X_from, X_to);
}
void Cutter::Lift() {
  state_->X_flanks.reset();
}
const std::array<double, 256>& Cutter::removed_mm3_by_region() const {
  return state_->removed_mm3;
}

double Cutter::State::Cut(const Pose& X_from, const Pose& X_to) {
  const DiscSweep sweep = MakeDiscSweep(saw, X_from, X_to);
  candidates.clear();
  candidate_set.Clear();
  if (FlanksMoved(X_to)) {
    FindLeavesAtDisc(sweep, X_to);
    X_flanks = X_to;
  } else {
    FindLeavesAtRim(sweep, X_to);
  }
  changed_count = 0;
  changed_map.Clear();
  for (const Coord& origin : candidates) CarveLeaf(sweep, X_to, origin);
  const double loss_mm3 = MeasureLoss();
  Commit();
  return loss_mm3;
}

/// Whether any point of the flats has moved along the spindle by more than the tolerance.
bool Cutter::State::FlanksMoved(const Pose& X) const {
  if (!X_flanks) return true;
  const Vec3 normal = X.Vector({0, 0, 1});
  const double along = std::abs(glm::dot(normal, X.p_AB - X_flanks->p_AB));
  const double tilt = glm::length(glm::cross(normal, X_flanks->Vector({0, 0, 1})));
  return along + tilt * saw.radius_mm() > kFlankTolerance * h;
}

void Cutter::State::AddLeavesInBall(const Vec3& centre_W, double radius_mm) {
  const Vec3 centre = centre_W / h;
  const double radius = radius_mm / h;
  const Coord first = LeafOrigin(centre - radius);
  const Coord last = LeafOrigin(centre + radius);
  for (int x = first.x(); x <= last.x(); x += kLeafEdge) {
    for (int y = first.y(); y <= last.y(); y += kLeafEdge) {
      for (int z = first.z(); z <= last.z(); z += kLeafEdge) {
        const Vec3 lower(x, y, z);
        const Vec3 nearest = glm::clamp(centre, lower, lower + (kLeafEdge - 1.0));
        const Vec3 offset = nearest - centre;
        if (glm::dot(offset, offset) > radius * radius) continue;
        const Coord origin(x, y, z);
        if (candidate_set.Insert(origin, 0)) candidates.push_back(origin);
      }
    }
  }
}

void Cutter::State::FindLeavesAtRim(const DiscSweep& sweep, const Pose& X) {
  if (sweep.length_mm == 0) return;
  // What the moving rim can change: |z| within the band of the flats, and from the band outside the rim to where the
  // flats are nearer than the rim. Covered by balls along the rim's outgoing half.
  const double out = band_mm + sweep.length_mm;
  const double in = sweep.half_thickness_mm + 2 * sweep.length_mm + kFlankTolerance * h;
  const double axial = sweep.half_thickness_mm + band_mm;
  const double mid = 0.5 * (out - in);
  const double half_width = 0.5 * (out + in);
  const double step_mm = 2 * h;
  const double ball = std::sqrt(half_width * half_width + axial * axial + step_mm * step_mm / 4);
  const double ring = sweep.radius_mm + mid;
  const int steps = static_cast<int>(std::ceil(kPi * ring / step_mm));
  const Vec3 u = -sweep.back_T / sweep.length_mm;
  const Vec3 v(-u.y, u.x, 0);
  for (int i = 0; i <= steps; ++i) {
    const double theta = kPi * (static_cast<double>(i) / steps - 0.5);
    AddLeavesInBall(X.Point(ring * (std::cos(theta) * u + std::sin(theta) * v)), ball);
  }
}

void Cutter::State::FindLeavesAtDisc(const DiscSweep& sweep, const Pose& X) {
  // Each leaf that comes within the band of the swept stadium.
  const double reach = sweep.radius_mm + band_mm;
  const Vec3 normal = X.Vector({0, 0, 1});
  Box3 box;
  const Vec3 half = reach * glm::sqrt(glm::max(Vec3(0), 1.0 - normal * normal)) +
                    (sweep.half_thickness_mm + band_mm) * glm::abs(normal);
  for (const Vec3& centre : {X.p_AB, X.Point(sweep.back_T)}) {
    box.Include(centre - half);
    box.Include(centre + half);
  }
  const Coord first = LeafOrigin(box.lower / h);
  const Coord last = LeafOrigin(box.upper / h);
  for (int x = first.x(); x <= last.x(); x += kLeafEdge) {
    for (int y = first.y(); y <= last.y(); y += kLeafEdge) {
      for (int z = first.z(); z <= last.z(); z += kLeafEdge) {
        const Vec3 p_T = X.InversePoint(h * (Vec3(x, y, z) + 0.5 * (kLeafEdge - 1)));
        if (sweep.Distance(p_T.x, p_T.y, p_T.z) > band_mm + kHalfLeafDiagonal * h) continue;
        const Coord origin(x, y, z);
        if (candidate_set.Insert(origin, 0)) candidates.push_back(origin);
      }
    }
  }
}

/// Works out a leaf's values after the cut; keeps them when any differs.
void Cutter::State::CarveLeaf(const DiscSweep& sweep, const Pose& X, const Coord& origin) {
  const FloatLeaf* leaf = phi.probeConstLeaf(origin);
  const float uniform = leaf ? 0.0f : phi.getValue(origin);
  if (!leaf && uniform >= 0) return;  // no bone here
  const Vec3 corner_T = X.InversePoint(h * Vec3(origin.x(), origin.y(), origin.z()));
  const Vec3 step_x = X.InverseVector({h, 0, 0});
  const Vec3 step_y = X.InverseVector({0, h, 0});
  const Vec3 step_z = X.InverseVector({0, 0, h});
  const Vec3 middle_T = corner_T + 3.5 * (step_x + step_y + step_z);
  if (sweep.Distance(middle_T.x, middle_T.y, middle_T.z) > band_mm + kHalfLeafDiagonal * h) return;

  if (changed_count == changed.size()) changed.emplace_back();
  ChangedLeaf& after = changed[changed_count];
  if (leaf) {
    std::copy_n(leaf->buffer().data(), FloatLeaf::SIZE, after.values.begin());
  } else {
    after.values.fill(uniform);
  }
  const float band = static_cast<float>(band_mm);
  int differing = 0;
  for (int x = 0; x < kLeafEdge; ++x) {
    for (int y = 0; y < kLeafEdge; ++y) {
      const Vec3 row_T = corner_T + static_cast<double>(x) * step_x + static_cast<double>(y) * step_y;
      float* row = &after.values[64 * x + 8 * y];
      for (int z = 0; z < kLeafEdge; ++z) {
        const double px = row_T.x + z * step_z.x;
        const double py = row_T.y + z * step_z.y;
        const double pz = row_T.z + z * step_z.z;
        const float carved = std::min(static_cast<float>(-sweep.Distance(px, py, pz)), band);
        differing += carved > row[z] ? 1 : 0;
        row[z] = std::max(row[z], carved);
      }
    }
  }
  if (differing == 0) return;
  after.origin = origin;
  changed_map.Insert(origin, static_cast<int>(changed_count));
  ++changed_count;
}

/// Volume of the cells before less after, over every cell with a changed corner.
double Cutter::State::MeasureLoss() {
  owner_set.Clear();
  double loss_mm3 = 0;
  for (std::size_t n = 0; n < changed_count; ++n) {
    // Cells belong to the leaf of their lowest corner: this one's and its lower neighbours'.
    for (int corner = 0; corner < 8; ++corner) {
      const Coord owner =
          changed[n].origin.offsetBy((corner & 4) ? -8 : 0, (corner & 2) ? -8 : 0, (corner & 1) ? -8 : 0);
      if (owner_set.Insert(owner, 0)) loss_mm3 += MeasureLossInBlock(owner);
    }
  }
  return loss_mm3;
}

double Cutter::State::MeasureLossInBlock(const Coord& owner) {
  CellBlock before;
  before.Load(phi, owner);
  CellBlock after = before;
  for (int part = 0; part < 8; ++part) {
    const int bx = (part >> 2) & 1;
    const int by = (part >> 1) & 1;
    const int bz = part & 1;
    const int index = changed_map.Find(owner.offsetBy(8 * bx, 8 * by, 8 * bz));
    if (index < 0) continue;
    const float* values = changed[index].values.data();
    for (int x = 0; x < (bx ? 1 : 8); ++x) {
      for (int y = 0; y < (by ? 1 : 8); ++y) {
        for (int z = 0; z < (bz ? 1 : 8); ++z)
          after.at(8 * bx + x, 8 * by + y, 8 * bz + z) = values[64 * x + 8 * y + z];
      }
    }
  }
  // Only a cell that has lost a corner's worth and that the surface passes through before or after has changed: of its
  // corners one was inside, one is outside now, and one has changed. Most cells of the band fail that.
  constexpr int kEdge = CellBlock::kEdge;
  constexpr int kCount = kEdge * kEdge * kEdge;
  std::array<std::uint8_t, kCount> flags;
  for (int i = 0; i < kCount; ++i) {
    const float old = before.data()[i];
    const float now = after.data()[i];
    flags[i] = static_cast<std::uint8_t>((old < 0 ? 1 : 0) | (now >= 0 ? 2 : 0) | (now != old ? 4 : 0));
  }
  for (const int stride : {1, kEdge, kEdge * kEdge}) {
    for (int i = 0; i + stride < kCount; ++i) flags[i] = static_cast<std::uint8_t>(flags[i] | flags[i + stride]);
  }
  double loss = 0;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        if (flags[(x * kEdge + y) * kEdge + z] != 7) continue;
        const double share = CalcCellShare(before.Corners(x, y, z)) - CalcCellShare(after.Corners(x, y, z));
        const Vec3 centre = h * (Vec3(owner.x() + x, owner.y() + y, owner.z() + z) + 0.5);
        const int id = region.getValue(NearestVoxel(centre, region_h));
        removed_mm3[static_cast<std::size_t>(std::clamp(id, 0, 255))] += share * h * h * h;
        loss += share;
      }
    }
  }
  return loss * h * h * h;
}

void Cutter::State::Commit() {
  const float band = static_cast<float>(band_mm);
  for (std::size_t n = 0; n < changed_count; ++n) {
    FloatLeaf* leaf = phi.touchLeaf(changed[n].origin);
    for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
      const float value = changed[n].values[i];
      leaf->setValueOnly(i, value);
      leaf->setActiveState(i, std::abs(value) < band);
    }
  }
}

}  // namespace kerf
