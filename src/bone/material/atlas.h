// Assignment of points of a mandible to the 31 cortical regions.
#pragma once

#include <array>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Coordinates of a point relative to the mandible, independent of the bone's position and orientation.
struct MandibleCoordinates {
  int side = 0;           // 0: the patient's right, 1: left
  double along = 0;       // along the arch: 0 at the symphysis, 1 below the back edge of the ramus
  double depth = 0;       // in the body: 0 at the crest, 1 at the lower border; less or more beyond them
  double rise = 0;        // height above the base plane (chin and angles), as a fraction of that of the highest point
  double forward_mm = 0;  // forward of the ramus's middle at this height
  double facial_mm = 0;   // outward from the middle of the bone's thickness at this place; negative: lingual
};

/// Cells of the cortex in the mandible's own coordinates: along the arch (symphysis to condyle), up, and facial or
/// lingual. The cells and their numbers are kerf's own, because the published site map was not available. Regions 24,
/// 21, 13 and 6 are stacked so that a cut through the body passes through them in the paper's order and depth bands
/// (docs/materials.md). Both halves have the same cells.
class MandibleAtlas {
 public:
  /// `points_W`: at least 100 points distributed over the bone's surface or volume, LPS, mm. `up_W`: towards the top of
  /// the head, to about 20 degrees. Omit tooth crowns if they are known, because the bands of height are scaled to the
  /// points. If the points are more than about 5 mm apart, the cells' borders become imprecise. Throws kerf::Error if
  /// there are fewer points, or if they are collinear or have no extent.
  explicit MandibleAtlas(const std::vector<Vec3>& points_W, const Vec3& up_W = {0, 0, 1});

  /// Returns the id, 1 to 31, of the cortical region nearest to a point. Thread-safe.
  int RegionAt(const Vec3& p_W) const;
  /// Returns the coordinates of a point. Thread-safe.
  MandibleCoordinates CalcCoordinates(const Vec3& p_W) const;

  /// The paper's depth bands of regions 24, 21, 13 and 6 (0-7.5-17.5-20-32.5 mm) as fractions of the body's height; an
  /// interpretation of its Table 2, which gives only depths.
  static constexpr std::array<double, 5> kBodyBands = {0, 7.5 / 32.5, 17.5 / 32.5, 20 / 32.5, 1};
  /// Start and end, along the arch, of the column with regions 24, 21, 13 and 6.
  static constexpr std::array<double, 2> kMolarColumn = {0.30, 0.53};

 private:
  // Frame M, the mandible's axes: x to the patient's left, f forward, h up from the base plane; origin in the midline
  // at the back, on the base plane.
  Vec3 origin_W_{0};
  Vec3 x_W_{1, 0, 0};
  Vec3 f_W_{0, -1, 0};
  Vec3 h_W_{0, 0, 1};
  double height_mm_ = 1;  // of the highest point: a condyle or a coronoid

  // The arch seen from above, by angle around the origin; the angle 0 is forward.
  static constexpr int kAngles = 52;
  static constexpr int kHeights = 24;
  static constexpr double kMaxAngle = 2.3;  // radians
  struct Side {
    std::array<double, kAngles> radius{};  // of the arch's middle, mm
    std::array<double, kAngles> along{};   // arc length divided by that of the ramus's back edge
    std::array<double, kAngles> crest{};   // h of the body's upper border, mm
    std::array<double, kAngles> base{};    // h of its lower border, mm
    std::array<std::array<double, kHeights>, kAngles>
        middle{};                                        // distance from the axis to the middle of the thickness, mm
    std::array<std::array<double, 2>, kAngles> point{};  // |x| and f of the arch's middle, mm
  };
  std::array<Side, 2> sides_;
  double ramus_middle_mm_ = 0;  // f of the ramus's middle at h = 0, extended
  double ramus_lean_ = 0;       // change of this f with h
  double condyle_top_ = 1;      // rise of the highest point behind the ramus's middle

  Vec3 ToMandible(const Vec3& p_W) const;
  /// Returns the position along the arch, in bins, that is nearest to a point when seen from above.
  static double FindBin(const Side& arch, const Vec3& p_M, double angle);
  void FindAxes(const std::vector<Vec3>& points_W, const Vec3& up_W);
  void FindArch(const std::vector<Vec3>& points_M, int side);
  void FindRamus(const std::vector<Vec3>& points_M);
};

}  // namespace kerf
