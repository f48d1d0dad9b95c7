// Bone dust that flies off the cut, for the picture only. Pure: equal calls give equal grains.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Grain as it is drawn.
struct DustGrain {
  Vec3 p_W{0};
  double diameter_mm = 0.3;
  double opacity = 1;  // 0 to 1; fades with age
};

/// Grains with a bounded number and a short life. They leave the cut with the speed of the teeth, are slowed down by
/// the air, and sink. Their number is proportional to the removed volume until the bound is reached.
class DustCloud {
 public:
  static constexpr double kGrainsPerMm3 = 60;
  static constexpr double kLife_s = 0.9;  // of the longest-lived grain

  explicit DustCloud(std::size_t max_grains = 1200, std::uint32_t seed = 1) : max_grains_(max_grains), random_(seed) {}

  /// Sets the bound; removes the oldest grains if there are more.
  void set_max_grains(std::size_t max_grains);
  /// Adds the dust of a removed volume at `p_W`, world frame. `v_W`: the velocity of the teeth there, mm/s; its
  /// direction counts, and its magnitude up to 150 mm/s. A volume of less than a grain is kept for the next call. If
  /// there would be too many grains, the oldest are removed. Ignores a volume that is not above 0 or values that are
  /// not finite.
  void Add(const Vec3& p_W, const Vec3& v_W, double volume_mm3);
  /// Moves all grains; removes those whose life has ended. Ignores times that are not above 0.
  void Advance(double dt_s);
  void Clear();

  std::size_t size() const { return grains_.size(); }
  std::vector<DustGrain> MakeGrains() const;

 private:
  struct Flying {
    Vec3 p_W{0};
    Vec3 v_W{0};
    double diameter_mm = 0.3;
    double age_s = 0;
    double life_s = kLife_s;
  };

  std::size_t max_grains_;
  std::mt19937 random_;
  std::vector<Flying> grains_;  // oldest first
  double rest_mm3_ = 0;         // removed volume that has not become a grain yet
};

}  // namespace kerf
