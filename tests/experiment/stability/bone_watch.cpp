#include "experiment/stability/bone_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "cut/contact/probe.h"
#include "cut/tool/shape.h"

namespace kerf::test {
namespace {

constexpr double kPieceVoxels = 0.25;  // maximum spacing of the recorded poses of a motion
constexpr double kTilt = 1e-12;
constexpr double kAll = std::numeric_limits<double>::infinity();

double CalcHeight(const Tool& tool) {
  return std::holds_alternative<DiscSaw>(tool) ? CalcThickness(tool) : 2 * CalcReach(tool);
}

/// Returns the width of the kerf, which is at least slightly more than a voxel (docs/physics.md).
double CalcKerf(const DiscSaw& disc, double h) {
  return std::max(disc.thickness_mm, 1.005 * h);
}

Vec3 VoxelCentre(const LeafIndex& leaf, int offset, double h) {
  return h * Vec3(8 * leaf.x + (offset >> 6), 8 * leaf.y + (offset >> 3 & 7), 8 * leaf.z + (offset & 7));
}

double Occupancy(float phi, double h) {
  return std::clamp(0.5 - static_cast<double>(phi) / h, 0.0, 1.0);
}

}  // namespace

BoneWatch::BoneWatch(const Bone& before, const Tool& tool, CutWith with)
    : before_(before),
      tool_(tool),
      with_(with),
      h_(before.voxel_mm()),
      reach_mm_(CalcReach(tool)),
      box_(before.CalcBounds()) {}

double BoneWatch::CalcDistance(const Pose& X_WT, const Vec3& p_W) const {
  const Vec3 p = X_WT.InversePoint(p_W);
  const auto* disc = std::get_if<DiscSaw>(&tool_);
  if (!disc) return glm::length(p) - reach_mm_;
  const double radial = std::hypot(p.x, p.y) - disc->radius_mm();
  const double axial = std::abs(p.z) - 0.5 * CalcKerf(*disc, h_);
  return std::min(std::max(radial, axial), 0.0) + std::hypot(std::max(radial, 0.0), std::max(axial, 0.0));
}

bool BoneWatch::MayTouch(const Pose& X_from, const Pose& X_to, double margin_mm) const {
  if (box_.empty()) return false;
  Box3 passed;
  passed.Include(X_from.p_AB);
  passed.Include(X_to.p_AB);
  passed = passed.Grown(reach_mm_ + margin_mm);
  for (int i = 0; i < 3; ++i) {
    if (passed.upper[i] < box_.lower[i] || passed.lower[i] > box_.upper[i]) return false;
  }
  return true;
}

void BoneWatch::Move(const Pose& X_from, const Pose& X_to, double stray_mm, bool cut) {
  if (!MayTouch(X_from, X_to, before_.band_mm() + stray_mm)) return;
  // A step sweeps its motion with the orientation, and the position along the spindle, that the tool has at its end.
  const Vec3 axis = X_to.Vector({0, 0, 1});
  const double tilt = glm::length(glm::cross(axis, X_from.Vector({0, 0, 1})));
  const double motion_mm = glm::length(X_to.p_AB - X_from.p_AB);
  const double along_mm = std::abs(glm::dot(axis, X_to.p_AB - X_from.p_AB)) + tilt * (reach_mm_ + motion_mm);
  const double layer_mm = 0.25 * std::min(h_, CalcHeight(tool_));
  const double travel_mm = tilt > kTilt ? CalcTravel(X_from, X_to, reach_mm_) : motion_mm;
  const double pieces = std::max(1.0, std::ceil(travel_mm / (kPieceVoxels * h_)));
  const double stray = stray_mm + 0.5 * travel_mm / pieces + std::min(along_mm, layer_mm);
  for (double i = 0; i < pieces; ++i) {
    const Pose X = i == 0 ? X_from : Interpolate(X_from, X_to, i / pieces);
    if (i == 0 && !passed_.empty()) {
      // The last motion ended at this pose.
      Passed& last = passed_.back();
      if (last.X_WT.p_AB == X.p_AB && last.X_WT.R_AB == X.R_AB) {
        last.stray_mm = std::max(last.stray_mm, stray);
        continue;
      }
    }
    passed_.push_back({X, stray, false});
  }
  passed_.push_back({X_to, stray, cut});
}

std::vector<std::string> BoneWatch::Check(const Bone& after, const Removed& removed) {
  std::vector<std::string> found;
  Bone now = after;
  {
    const BoneField old_field(before_, 0);
    const BoneField new_field(now, 0);
    const LeafIndex low = old_field.lowest();
    const LeafIndex high = old_field.highest();
    // Each field has its own frame: if there is less bone, the origin may differ.
    const LeafIndex a = old_field.origin_leaf();
    const LeafIndex b = new_field.origin_leaf();
    bool fell = false;
    bool strayed = false;
    double lost_voxels = 0;
    std::size_t hint = 0;
    for (int x = low.x; x <= high.x; ++x) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int z = low.z; z <= high.z; ++z) {
          const LeafIndex leaf{x, y, z};
          const float* was = old_field.Read(leaf);
          const float* is = new_field.Read({x + a.x - b.x, y + a.y - b.y, z + a.z - b.z});
          if (was == is || std::equal(was, was + BoneField::kLeafVoxels, is)) continue;
          for (int i = 0; i < BoneField::kLeafVoxels; ++i) {
            if (was[i] == is[i]) continue;
            const Vec3 p_W = old_field.p_WF_mm() + VoxelCentre(leaf, i, h_);
            lost_voxels += Occupancy(was[i], h_) - Occupancy(is[i], h_);
            if (!(is[i] > was[i])) {
              if (!fell) {
                found.push_back(
                    fmt::format("I5: phi fell from {} to {} mm at ({}, {}, {})", was[i], is[i], p_W.x, p_W.y, p_W.z));
              }
              fell = true;
              continue;
            }
            if (strayed) continue;
            // Finds the pose that explains the value, beginning with the one that explained the previous value.
            const double slack_mm = 0.005 * h_ + 4e-6 * reach_mm_;
            double min_mm = kAll;
            const auto explains = [&](std::size_t n) {
              const double d = CalcDistance(passed_[n].X_WT, p_W) - passed_[n].stray_mm;
              min_mm = std::min(min_mm, d);
              if (d > -static_cast<double>(is[i]) + slack_mm) return false;
              hint = n;
              return true;
            };
            bool explained = false;
            for (std::size_t k = 0; k < passed_.size() && !explained; ++k) {
              const bool up = hint + k < passed_.size();
              const bool down = k > 0 && k <= hint;
              if (!up && !down) break;
              explained = (up && explains(hint + k)) || (down && explains(hint - k));
            }
            if (!explained) {
              strayed = true;
              found.push_back(
                  fmt::format("I6: phi rose from {} to {} mm at ({}, {}, {}), {} mm from where the tool was", was[i],
                              is[i], p_W.x, p_W.y, p_W.z, min_mm));
            }
          }
        }
      }
    }
    CheckEdges(new_field, found);
    const double lost_mm3 = lost_voxels * h_ * h_ * h_;
    // Each leaf is a sum of 512 floats.
    if (removed.by_ticks_mm3 >= 0 && std::abs(removed.by_ticks_mm3 - lost_mm3) > 1e-4 * lost_mm3 + 1e-6) {
      found.push_back(fmt::format("I4: the ticks removed {} mm^3, but voxels lost {} mm^3 of occupancy",
                                  removed.by_ticks_mm3, lost_mm3));
    }
  }
  if (removed.exact_mm3 >= 0) {
    const double was = before_.CalcVolume();
    const double is = now.CalcVolume();
    const double gone = removed.exact_mm3 - removed_mm3_;
    // The same cells are added in a different order, so only rounding errors may differ.
    if (!(std::abs(gone + is - was) <= 1e-9 * was)) {
      found.push_back(fmt::format("I4: removed {} + remaining {} mm^3 is not the initial {}", gone, is, was));
    }
    removed_mm3_ = removed.exact_mm3;
  }
  before_ = std::move(now);
  passed_.clear();
  return found;
}

/// Checks that wherever the edge certainly cut, each voxel next to it is removed as far as the tool reaches.
void BoneWatch::CheckEdges(const BoneField& field, std::vector<std::string>& found) const {
  const auto* disc = std::get_if<DiscSaw>(&tool_);
  if (!disc) return;
  constexpr int kPoints = 48;
  const double depth_mm = with_ == CutWith::kEdge ? CalcToothSide(disc->radius_mm(), h_) - 0.01 * h_ : kAll;
  const double slack_mm = (Cutter::kFlankTolerance + 0.005) * h_ + 4e-6 * reach_mm_;
  for (std::size_t n = 0; n < passed_.size(); ++n) {
    if (!passed_[n].cut) continue;
    const Pose& X = passed_[n].X_WT;
    for (int i = 0; i < kPoints; ++i) {
      // Checks different points of the edge each time.
      const double angle = 2 * std::numbers::pi * (i + 0.618034 * static_cast<double>(n)) / kPoints;
      const double r = disc->radius_mm() + h_ * (1 - 0.5 * static_cast<double>(n % 5));
      if (r <= 0) continue;
      // Checks the disc's plane and one voxel to either side, which are the walls of its kerf.
      const double z = h_ * ((i + static_cast<int>(n % 3)) % 3 - 1);
      const Vec3 p_W = X.Point({r * std::cos(angle), r * std::sin(angle), z});
      const Vec3 v = glm::round((p_W - field.p_WF_mm()) / h_);
      const LeafIndex leaf{static_cast<int>(std::floor(v.x / 8)), static_cast<int>(std::floor(v.y / 8)),
                           static_cast<int>(std::floor(v.z / 8))};
      const int offset = static_cast<int>(v.x - 8 * leaf.x) << 6 | static_cast<int>(v.y - 8 * leaf.y) << 3 |
                         static_cast<int>(v.z - 8 * leaf.z);
      const Vec3 voxel_W = field.p_WF_mm() + h_ * v;
      const Vec3 p_T = X.InversePoint(voxel_W);
      if (std::hypot(p_T.x, p_T.y) - disc->radius_mm() < -depth_mm) continue;
      const double distance = CalcDistance(X, voxel_W);
      const double phi = static_cast<double>(field.Read(leaf)[offset]);
      if (distance < before_.band_mm() && phi < -distance - slack_mm) {
        found.push_back(fmt::format("I7: the edge passed ({}, {}, {}), {} mm from the tool, and phi is still {} mm",
                                    voxel_W.x, voxel_W.y, voxel_W.z, distance, phi));
        return;
      }
    }
  }
}

}  // namespace kerf::test
