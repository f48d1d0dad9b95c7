// Convergence of the force for each knob separately, with all other settings unchanged. A study cannot show it where
// the errors of another knob remain (docs/accuracy.md).
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <vector>

#include "experiment/study/case_run.h"
#include "experiment/study/paths.h"

namespace kerf {
namespace {

/// Returns the root mean square of the difference at the ticks of `coarse`, each taken at the end of its tick, N.
double CalcRmsDifference(const std::vector<Vec3>& coarse, const std::vector<Vec3>& fine) {
  const std::size_t stride = fine.size() / coarse.size();
  double sum = 0;
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    const Vec3 off = coarse[i] - fine[(i + 1) * stride - 1];
    sum += glm::dot(off, off);
  }
  return std::sqrt(sum / static_cast<double>(coarse.size()));
}

struct Orders {
  std::vector<double> apart_N;  // difference between coarse and fine
  double order = 0;             // slope of log difference over log number, from the first value to the last
};

Orders Measure(const char* path_name, Holding holding, const std::vector<double>& numbers, double finest,
               const std::function<void(StudySettings&, double)>& set) {
  const std::optional<StudyPath> path = MakeBlockPath(path_name);
  const auto run = [&](double number) {
    StudySettings settings;
    set(settings, number);
    return RunCasePass(*path, holding, settings).f_W_N;
  };
  const std::vector<Vec3> best = run(finest);
  Orders orders;
  for (const double number : numbers) orders.apart_N.push_back(CalcRmsDifference(run(number), best));
  orders.order = std::log(orders.apart_N.front() / orders.apart_N.back()) / std::log(numbers.front() / numbers.back());
  std::printf("%s %s:", path_name, holding == Holding::kHand ? "hand" : "path");
  for (std::size_t i = 0; i < numbers.size(); ++i) std::printf(" %g: %.3g mN;", numbers[i], 1000 * orders.apart_N[i]);
  std::printf(" order %.2f\n", orders.order);
  return orders;
}

constexpr const char* kPaths[] = {"plunge", "slot", "tilt"};

TEST(KnobOrders, SubstepsAreOfFirstOrder) {
  // Errors of 1/n, measured against 32 steps, are proportional to 1/n - 1/32. From 1 to 4 steps that is a factor of
  // 31/7, which is 4 to the power of 1.07.
  const double first = -std::log(31.0 / 7) / std::log(4.0);
  for (const char* path : kPaths) {
    for (const Holding holding : {Holding::kHand, Holding::kPath}) {
      std::printf("substeps, ");
      const Orders found =
          Measure(path, holding, {1, 2, 4}, 32, [](StudySettings& s, double n) { s.substeps = static_cast<int>(n); });
      EXPECT_NEAR(found.order, first, 0.1) << path;  // the grid's ripple: some hundredths
    }
  }
}

TEST(KnobOrders, TheRateIsOfFirstOrder) {
  // Measured against 4000 Hz, the factor is 5 from 250 to 1000 Hz. This is checked only on a path, because coupled
  // paths depend on the tick of first contact.
  const double first = -std::log(5.0) / std::log(4.0);
  for (const char* path : kPaths) {
    std::printf("rate_hz, ");
    const Orders found =
        Measure(path, Holding::kPath, {250, 500, 1000}, 4000, [](StudySettings& s, double n) { s.rate_hz = n; });
    EXPECT_NEAR(found.order, first, 0.1) << path;
  }
}

TEST(KnobOrders, RimSamplesAreAtLeastOfFirstOrder) {
  // Between the points the integral is of second order; the ends of an arc are found to within a sixteenth of the
  // points' distance.
  for (const char* path : kPaths) {
    for (const Holding holding : {Holding::kHand, Holding::kPath}) {
      std::printf("rim_samples_per_pitch, ");
      const Orders found = Measure(path, holding, {4, 8, 16, 32}, 256,
                                   [](StudySettings& s, double n) { s.rim_samples_per_pitch = static_cast<int>(n); });
      EXPECT_LT(found.order, -1) << path;
    }
  }
}

TEST(KnobOrders, DelayedRemovalIsOfFirstOrderUpToAQuarterOfAVoxel) {
  // Relative to removal in each tick, the lag is n - 1 ticks, which triples from 2 to 4. For faster tools, the bound
  // limits it.
  std::printf("carve_interval_ticks, ");
  const Orders slow = Measure("tilt", Holding::kHand, {16, 8, 4, 2}, 1,
                              [](StudySettings& s, double n) { s.carve_interval_ticks = static_cast<int>(n); });
  EXPECT_NEAR(slow.apart_N[2] / slow.apart_N[3], 3, 0.5);
  EXPECT_LT(slow.apart_N[0] / slow.apart_N[1], 1.5);  // a factor of two without the bound
}

}  // namespace
}  // namespace kerf
