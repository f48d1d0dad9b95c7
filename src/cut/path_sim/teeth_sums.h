// Sums over the teeth and the substeps of a tick, for a tool on a path and for a coupled tool.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "kerf/simulation.h"

namespace kerf {

/// Each addend has the weight of its substep: 1, or its duration.
struct TeethSums {
  double thrust_N = 0;
  double thrust_W = 0;   // thrust times speed of the teeth
  double cutting_N = 0;  // 0 unless the law states a cutting force, as the next one
  double cutting_W = 0;  // power of the cutting force at the speed of the teeth
  double teeth = 0;      // engaged teeth, a real number
  double E_MPa = 0;      // of the engaged teeth
  double bite_mm = 0;
  std::array<double, 256> thrust_by_region_N{};

  void Add(const TeethSums& other) {
    thrust_N += other.thrust_N;
    thrust_W += other.thrust_W;
    cutting_N += other.cutting_N;
    cutting_W += other.cutting_W;
    teeth += other.teeth;
    E_MPa += other.E_MPa;
    bite_mm += other.bite_mm;
    for (std::size_t id = 0; id < thrust_by_region_N.size(); ++id) {
      thrust_by_region_N[id] += other.thrust_by_region_N[id];
    }
  }
  /// Adds the thrust, the mean over the way of the teeth, at the given speed along it.
  void AddThrustPower(double on_way_N, double weight, double speed_mm_per_s) {
    thrust_W += weight * 1e-3 * on_way_N * speed_mm_per_s;
  }
  /// Adds the cutting force of teeth that move at the given speed.
  void AddCutting(double sum_N, double weight, double speed_mm_per_s) {
    cutting_N += weight * sum_N;
    cutting_W += weight * 1e-3 * sum_N * speed_mm_per_s;
  }
  /// Sets the means. `weight`: sum of the weights, above 0.
  void Report(double weight, TeethOutput& out) const {
    out.thrust_sum_N = thrust_N / weight;
    out.thrust_W = thrust_W / weight;
    out.cutting_sum_N = cutting_N / weight;
    out.cutting_W = cutting_W / weight;
    out.engaged_teeth = teeth / weight;
    if (!(teeth > 0)) return;
    out.mean_E_MPa = E_MPa / teeth;
    out.mean_bite_mm = bite_mm / teeth;
    const auto main = std::max_element(thrust_by_region_N.begin(), thrust_by_region_N.end());
    if (*main > 0) out.main_region = static_cast<int>(main - thrust_by_region_N.begin());
  }
};

}  // namespace kerf
