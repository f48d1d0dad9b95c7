#include "bone/import/ct_solid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bone/import/smooth.h"

namespace kerf {

namespace {

constexpr double kHuScale = 1000;  // gives the two parts of the value similar slopes
constexpr double kBoxMargin_vox = 3;
constexpr double kBorderSmoothing_mm = 1.2;  // of the border to the dropped bone

// Level of the border in the smoothed membership (1 on the wanted side, 0 on the other): a third of a voxel towards the
// wanted side, so that no thin remnants of the other bone are left across a narrow joint.
constexpr double kBorder = 0.62;

// Returns the standard deviation of the blur, in voxels, by axis; 0 along the coarsest. A surface that is not
// perpendicular to the slices jumps from slice to slice, and interpolation turns the jumps into ripples. Therefore the
// slices are blurred in their plane as much as a slice blurs across it: a box of thickness h has a standard deviation
// of 0.29 h.
Vec3 CalcInPlaneBlur(const Vec3& spacing_mm) {
  const double coarsest = std::max({spacing_mm.x, spacing_mm.y, spacing_mm.z});
  Vec3 sigma_vox;
  for (int a = 0; a < 3; ++a) {
    const double h = spacing_mm[a];
    sigma_vox[a] = 0.29 * std::sqrt(std::max(coarsest * coarsest - h * h, 0.0)) / h;
  }
  return sigma_vox;
}

// Returns the coarseness of the sampling along each axis: 0 where it is as fine as along any other axis and at most
// kFine_mm, because such a CT resolves its own edges; near 1 where it is much coarser.
Vec3 CalcCoarseness(const Vec3& spacing_mm) {
  constexpr double kFine_mm = 1;
  const double fine = std::min({spacing_mm.x, spacing_mm.y, spacing_mm.z, kFine_mm});
  return 1.0 - fine * fine / (spacing_mm * spacing_mm);
}

// Returns half the width of the range to which the HU are limited: down to soft tissue where the sampling is coarse,
// unlimited where it is fine. Iso is low on the edge of bone (300 HU between soft tissue of 50 and cortex of 1600).
// Blur moves the low levels of an edge outward, and so does interpolation between widely spaced samples. Within the
// limited range, iso is the half height of the edge, which does not move when the HU are blurred and interpolated.
double CalcRange_HU(double coarsest, double iso_hu) {
  constexpr double kSoftTissue_HU = 50;
  return std::clamp(iso_hu - kSoftTissue_HU, 100.0, 300.0) / std::max(coarsest, 1e-9);
}

// Converts the CT's HU to the HU whose iso level is the surface.
void PrepareCoarse(const Volume& ct, double iso_hu, double range_hu, std::vector<float>& hu) {
  Sharpen(ct.size, CalcCoarseness(ct.spacing_mm), hu);
  for (float& h : hu) h = std::clamp(h, static_cast<float>(iso_hu - range_hu), static_cast<float>(iso_hu + range_hu));
  Smooth(ct.size, CalcInPlaneBlur(ct.spacing_mm), hu);
}

// Returns half the extent, in voxels, of the box around a ball of radius 1 mm.
Vec3 CalcReach(const LatticeMap& map) {
  Vec3 reach_V;
  for (int row = 0; row < 3; ++row) {
    // The image of the ball is an ellipsoid; its extent along a voxel axis is the length of that row.
    reach_V[row] =
        glm::length(Vec3(map.voxel_from_world[0][row], map.voxel_from_world[1][row], map.voxel_from_world[2][row]));
  }
  return reach_V;
}

// Returns 1 for the bone from which no voxel around leads out of bone and cavities.
std::vector<std::uint8_t> FindInner(const Isolation& isolation, const std::vector<std::uint8_t>& cavities) {
  const Volume& ct = isolation.ct;
  std::vector<std::uint8_t> inner(ct.count(), 0);
  for (int k = 1; k + 1 < ct.size[2]; ++k) {
    for (int j = 1; j + 1 < ct.size[1]; ++j) {
      for (int i = 1; i + 1 < ct.size[0]; ++i) {
        if (isolation.bone[ct.Index(i, j, k)] == 0) continue;
        bool enclosed = true;
        for (int side = 0; side < 27 && enclosed; ++side) {
          const std::size_t w = ct.Index(i + side % 3 - 1, j + side / 3 % 3 - 1, k + side / 9 - 1);
          enclosed = isolation.bone[w] != 0 || cavities[w] != 0;
        }
        inner[ct.Index(i, j, k)] = enclosed ? 1 : 0;
      }
    }
  }
  return inner;
}

// Returns the scan's HU with those of the cavities raised. Where the voxels of the isolation are larger than the
// scan's, those of the bone contain a part of the cavities beside them.
std::vector<float> FillScan(const Isolation& isolation, const std::vector<std::uint8_t>& cavities, float fill_hu) {
  const Volume& scan = isolation.fine();
  std::vector<std::uint8_t> inner;
  const bool fills = std::find(cavities.begin(), cavities.end(), 1) != cavities.end();
  if (isolation.scan.count() != 0 && fills) inner = FindInner(isolation, cavities);
  std::vector<float> hu(scan.count());
  tbb::parallel_for(0, scan.size[2], [&](int k) {
    for (int j = 0; j < scan.size[1]; ++j) {
      for (int i = 0; i < scan.size[0]; ++i) {
        const std::size_t v = scan.Index(i, j, k), of = isolation.Find(i, j, k);
        const auto own = static_cast<float>(scan.hu[v]);
        const bool raised = cavities[of] != 0 || (!inner.empty() && inner[of] != 0);
        hu[v] = raised ? std::max(own, fill_hu) : own;
      }
    }
  });
  return hu;
}

}  // namespace

CtSolid::CtSolid(const Isolation& isolation, const std::vector<std::uint8_t>& cavities, double iso_hu, double fill_hu)
    : iso_hu_(iso_hu), map_(isolation.fine()), side_map_(isolation.ct) {
  const Volume& ct = isolation.ct;
  const Volume& scan = isolation.fine();
  reach_V_ = CalcReach(map_);
  side_reach_V_ = CalcReach(side_map_);
  std::vector<float> wanted(ct.count());
  for (std::size_t v = 0; v < wanted.size(); ++v) {
    wanted[v] = isolation.keep[v] != 0 || cavities[v] != 0 ? 1.0f : 0.0f;
  }
  std::vector<float> hu = FillScan(isolation, cavities, static_cast<float>(fill_hu));
  for (int k = 0; k < ct.size[2]; ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) {
        if (isolation.bone[ct.Index(i, j, k)] == 0) continue;
        for (int corner = 0; corner < 8; ++corner) {
          const double m = kBoxMargin_vox;
          box_.Include(ct.WorldFromVoxel(
              {i + ((corner & 1) != 0 ? m : -m), j + ((corner & 2) != 0 ? m : -m), k + ((corner & 4) != 0 ? m : -m)}));
        }
      }
    }
  }
  const Vec3 coarseness = CalcCoarseness(scan.spacing_mm);
  const double range_hu = CalcRange_HU(std::max({coarseness.x, coarseness.y, coarseness.z}), iso_hu);
  if (range_hu < std::numeric_limits<std::int16_t>::max()) {
    std::vector<float> prepared = hu;
    PrepareCoarse(scan, iso_hu, range_hu, prepared);
    surface_hu_ = std::make_shared<SplineField>(scan.size, std::move(prepared), true);
  }
  Smooth(ct.size, glm::max(kBorderSmoothing_mm / ct.spacing_mm, Vec3(0.7)), wanted);
  hu_ = std::make_shared<SplineField>(scan.size, std::move(hu), true);
  if (!surface_hu_) surface_hu_ = hu_;
  wanted_ = std::make_unique<SplineField>(ct.size, std::move(wanted), false);
}

double CtSolid::Value(const Vec3& p_W) const {
  const double by_hu = (iso_hu_ - surface_hu_->At(map_.VoxelFromWorld(p_W))) / kHuScale;
  const double by_side = kBorder - wanted_->At(side_map_.VoxelFromWorld(p_W));
  return std::max(by_hu, by_side);
}

void CtSolid::EvaluateLeaf(const LeafPlace& leaf, LeafValues& values) const {
  std::array<double, 512> hu{}, wanted{};
  surface_hu_->AtLattice(map_.CalcPositions(leaf), hu);
  wanted_->AtLattice(side_map_.CalcPositions(leaf), wanted);
  for (std::size_t n = 0; n < values.size(); ++n) {
    values[n] = static_cast<float>(std::max((iso_hu_ - hu[n]) / kHuScale, kBorder - wanted[n]));
  }
}

BlockClass CtSolid::Classify(const Vec3& centre_W, double radius_mm) const {
  const Vec3 p_V = map_.VoxelFromWorld(centre_W);
  const Vec3 r_V = radius_mm * reach_V_;
  const SplineField::Bounds hu = surface_hu_->CalcBounds(p_V - r_V, p_V + r_V);
  if (hu.upper < iso_hu_) return BlockClass::kOutside;
  const Vec3 side_V = side_map_.VoxelFromWorld(centre_W), side_r_V = radius_mm * side_reach_V_;
  const SplineField::Bounds side = wanted_->CalcBounds(side_V - side_r_V, side_V + side_r_V);
  if (side.upper < kBorder) return BlockClass::kOutside;
  return hu.lower > iso_hu_ && side.lower > kBorder ? BlockClass::kInside : BlockClass::kMixed;
}

}  // namespace kerf
