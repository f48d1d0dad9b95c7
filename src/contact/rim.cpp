#include "contact/rim.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxHalvings = 6;             // of an interval in which engagement or material changes
constexpr double kEngagementChange = 0.02;  // that asks for halving

/// What a tooth at one angle meets.
struct Sample {
  double theta = 0;       // from the feed's direction, rad
  Vec3 e_T{0};            // outward
  double distance = 0;    // of the look-ahead point to the bone, mm
  double engagement = 0;  // 0 to 1
  int region = 0;         // of the nearest voxel
  double E_MPa = 0;       // interpolated between voxels
  double E_star_MPa = 0;
};

/// Looks at the bone from points of the rim.
class Prober {
 public:
  Prober(const BoneField& field, const RimMaterials& materials, const Pose& X_WT, double radius_mm, const Vec3& feed_T)
      : field_(field),
        materials_(materials),
        X_WT_(X_WT),
        h_(field.voxel_mm()),
        region_h_(field.region_voxel_mm()),
        radius_mm_(radius_mm),
        u_(feed_T),
        v_(-feed_T.y, feed_T.x, 0) {}

  Sample At(double theta) const {
    Sample sample;
    sample.theta = theta;
    sample.e_T = std::cos(theta) * u_ + std::sin(theta) * v_;
    const double look_ahead = kLookAheadVoxels * h_;
    const Vec3 p_W = X_WT_.Point((radius_mm_ + look_ahead) * sample.e_T);
    sample.distance = field_.Sample(p_W / h_);
    // Whole where bone fills the look-ahead, none where the surface is reached: continuous on entering and leaving.
    sample.engagement = std::clamp(-sample.distance / look_ahead, 0.0, 1.0);
    if (sample.engagement == 0) return sample;
    if (!FindMaterial(p_W, sample)) {
      // Coarse region voxels with their centres outside the bone: look one further in.
      FindMaterial(p_W + region_h_ * X_WT_.Vector(sample.e_T), sample);
    }
    return sample;
  }

 private:
  /// The moduli at a point, interpolated between the region voxels around it that have material: an arc that crosses a
  /// border between tissues all at once would else feel a step. False when there are none.
  bool FindMaterial(const Vec3& p_W, Sample& sample) const {
    const double E_ct_MPa = field_.ModulusAt(p_W);
    double sum = 0;
    double largest = 0;
    sample.region = 0;
    sample.E_MPa = 0;
    sample.E_star_MPa = 0;
    std::array<BoneField::RegionShare, 8> shares;
    const int count = field_.FindRegions(p_W, shares);
    for (int i = 0; i < count; ++i) {
      const auto& [id, weight] = shares[static_cast<std::size_t>(i)];
      sum += weight;
      if (E_ct_MPa > 0 && field_.by_modulus(id)) {
        sample.E_MPa += weight * E_ct_MPa;
        sample.E_star_MPa +=
            weight * CalcReducedModulus(materials_.steel_E_MPa, materials_.steel_nu, E_ct_MPa, materials_.nu[id]);
      } else {
        sample.E_MPa += weight * materials_.E_MPa[id];
        sample.E_star_MPa += weight * materials_.E_star_MPa[id];
      }
      if (weight > largest) {
        largest = weight;
        sample.region = id;
      }
    }
    if (!(sum > 0)) return false;
    sample.E_MPa /= sum;
    sample.E_star_MPa /= sum;
    return true;
  }

  const BoneField& field_;
  const RimMaterials& materials_;
  const Pose& X_WT_;
  double h_;
  double region_h_;
  double radius_mm_;
  Vec3 u_;  // feed direction in the disc's plane
  Vec3 v_;
};

}  // namespace

RimMaterials MakeRimMaterials(const MaterialTable& materials, const Tool& tool) {
  RimMaterials rim;
  rim.steel_E_MPa = CalcModulus(tool);
  rim.steel_nu = CalcPoissonRatio(tool);
  for (const auto& [id, region] : materials.regions()) {
    rim.E_MPa[id] = region.E_MPa;
    rim.nu[id] = region.nu;
    rim.E_star_MPa[id] = CalcReducedModulus(rim.steel_E_MPa, rim.steel_nu, region.E_MPa, region.nu);
  }
  return rim;
}

Rim::Rim(const DiscSaw& saw, const ToothForce& force, const RimMaterials& materials, int samples_per_pitch)
    : radius_mm_(saw.radius_mm()),
      teeth_(saw.teeth),
      force_(force),
      materials_(materials),
      half_samples_(std::max(32, saw.teeth * samples_per_pitch / 2)) {}

RimLoad Rim::CalcLoad(const BoneField& field, const Pose& X_WT, const Vec3& v_T_mm_per_s, double passes_per_s) const {
  RimLoad load;
  const Vec3 in_plane(v_T_mm_per_s.x, v_T_mm_per_s.y, 0);
  const double feed = glm::length(in_plane);
  if (!(feed > 0) || !(passes_per_s > 0)) return load;
  const double full_bite = feed / passes_per_s;
  const Prober prober(field, materials_, X_WT, radius_mm_, in_plane / feed);

  // Only the half of the rim that moves outwards can bite, so the integral over it has no edge of its own.
  const auto add_end = [&](const Sample& s, double teeth) {
    const double weight = s.engagement * teeth;
    if (weight == 0 || s.region == 0) return;
    const double bite = full_bite * std::max(0.0, std::cos(s.theta));
    const double force = weight * force_(bite, s.E_star_MPa);
    load.f_T_N -= force * s.e_T;
    load.thrust_sum_N += force;
    load.thrust_by_region_N[s.region] += force;
    load.engaged_teeth += weight;
    load.E_sum_MPa += weight * s.E_MPa;
    load.bite_sum_mm += weight * bite;
  };
  const double ring_mm = radius_mm_ + kLookAheadVoxels * field.voxel_mm();
  const auto add_interval = [&](const auto& self, const Sample& a, const Sample& b, int halvings) -> void {
    // A distance changes by at most 1 per mm: ends that are far enough from the bone have none between them.
    const double arc_mm = ring_mm * (b.theta - a.theta);
    if (a.engagement == 0 && b.engagement == 0 && a.distance + b.distance >= arc_mm) return;
    const bool both = a.engagement > 0 && b.engagement > 0;
    const bool uniform = both && std::abs(a.engagement - b.engagement) <= kEngagementChange && a.region == b.region;
    if (!uniform && halvings < kMaxHalvings) {
      const Sample middle = prober.At(0.5 * (a.theta + b.theta));
      self(self, a, middle, halvings + 1);
      self(self, middle, b, halvings + 1);
      return;
    }
    const double teeth = teeth_ / (2 * kPi) * (b.theta - a.theta);
    add_end(a, 0.5 * teeth);
    add_end(b, 0.5 * teeth);
  };
  const double step = kPi / half_samples_;
  Sample previous = prober.At(-0.5 * kPi);
  for (int i = 1; i <= half_samples_; ++i) {
    const Sample next = prober.At(-0.5 * kPi + i * step);
    add_interval(add_interval, previous, next, 0);
    previous = next;
  }
  return load;
}

}  // namespace kerf
