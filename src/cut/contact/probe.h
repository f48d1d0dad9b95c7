// Access to the bone from a tool at a given pose.
#pragma once

#include <glm/mat3x3.hpp>

#include "bone/grid/field.h"
#include "kerf/geometry.h"

namespace kerf {

/// Lipschitz constant of the interpolated distance, sqrt(3): a trilinear interpolation changes by at most this many mm
/// per mm.
inline constexpr double kMaxGradient = 1.7320508;

/// Distance field of the bone as a function of points of a tool at the pose X_WT; mm.
class Probe {
 public:
  Probe(const BoneField& field, const Pose& X_WT)
      : field_(field),
        R_(glm::mat3_cast(X_WT.R_AB) / field.voxel_mm()),
        t_(X_WT.p_AB / field.voxel_mm()),
        h_(field.voxel_mm()),
        X_WT_(X_WT) {}

  const Pose& X_WT() const { return X_WT_; }

  Vec3 Voxel(const Vec3& p_T) const { return R_ * p_T + t_; }
  Vec3 World(const Vec3& p_T) const { return h_ * Voxel(p_T); }
  /// Returns the distance from a point of the tool to the bone, mm, negative inside.
  double Distance(const Vec3& p_T) const { return field_.Sample(Voxel(p_T)); }
  /// Finds the two fields of which the distance is the larger (see BoneField), mm, one value per point.
  void Parts(const PointList& points_T, double* whole_mm, double* cut_mm) const {
    field_.SampleParts({R_, t_}, points_T, whole_mm, cut_mm);
  }
  /// Finds the distances of many points, with the bits of Distance().
  void Distances(const PointList& points_T, double* distances_mm) const {
    field_.Sample({R_, t_}, points_T, distances_mm);
  }
  /// BoneField::InterpolateUniform() for points of the tool.
  void InterpolateUniform(const PointList& points_T, const RegionConstants& constants, std::uint8_t* regions, double* a,
                          double* b) const {
    field_.InterpolateUniform({R_, t_}, points_T, constants, regions, a, b);
  }
  /// Returns the gradient of the distance in the tool frame, mm per mm. It points away from the bone.
  Vec3 Away(const Vec3& p_T) const { return h_ * (field_.SampleGradient(Voxel(p_T)) * R_); }

 private:
  const BoneField& field_;
  glm::dmat3 R_;
  Vec3 t_;
  double h_;
  Pose X_WT_;
};

}  // namespace kerf
