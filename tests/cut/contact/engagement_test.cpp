// The engaged part of the edge between two samples, compared with closed forms and with sums over many places.
#include "cut/contact/engagement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>

#include "base/core/heap_guard.h"
#include "cut/removal/carve.h"

namespace kerf {
namespace {

constexpr EngagementDepths kDepths{0.015, 0.005};

struct Sums {
  std::array<double, IntervalParts::kRoom> start{}, end{};
};

Sums Integrate(const IntervalParts& parts) {
  Sums sums;
  IntegrateEngagement(kDepths, parts, sums.start.data(), sums.end.data());
  return sums;
}

void Add(double t_a, double t_b, double whole_a, double whole_b, double cut_a, double cut_b, IntervalParts& parts) {
  const std::size_t i = parts.size++;
  parts.t_a[i] = t_a;
  parts.t_b[i] = t_b;
  parts.whole_a_mm[i] = whole_a;
  parts.whole_b_mm[i] = whole_b;
  parts.cut_a_mm[i] = cut_a;
  parts.cut_b_mm[i] = cut_b;
}

/// Adds parts in which both fields cross the depths over which the engagement rises, or do not.
void AddRandom(std::size_t count, IntervalParts& parts) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(0, 1);
  std::uniform_real_distribution<double> field(-0.03, 0.03);
  for (std::size_t i = 0; i < count; ++i) {
    const double a = place(random);
    const double b = place(random);
    const double whole_a = field(random);
    const double whole_b = i % 5 == 0 ? whole_a : field(random);
    const double cut_a = field(random);
    Add(std::min(a, b), std::max(a, b), whole_a, whole_b, cut_a, i % 7 == 0 ? cut_a : field(random), parts);
  }
}

TEST(Engagement, HasItsClosedFormWhereItIsConstantOrLinear) {
  IntervalParts parts;
  Add(0.25, 0.75, -1, -1, -1, -1, parts);                        // all engaged
  Add(0, 1, -1, -1, 0, -kDepths.look_ahead_mm, parts);           // rises from 0 to 1 by the cut
  Add(0, 1, 0.0075, -0.0075, -1, -1, parts);                     // and by the depth in the whole bone
  Add(0, 1, 0.0075, -0.0075, 0, -kDepths.look_ahead_mm, parts);  // by both
  Add(0, 1, -1, -1, 1, 2, parts);                                // nothing to cut
  Add(0, 1, 1, 2, -1, -1, parts);                                // no bone
  const Sums sums = Integrate(parts);
  const double start[6] = {0.25, 1 / 6.0, 1 / 6.0, 1 / 12.0, 0, 0};
  const double end[6] = {0.25, 1 / 3.0, 1 / 3.0, 1 / 4.0, 0, 0};
  for (std::size_t i = 0; i < parts.size; ++i) {
    EXPECT_NEAR(sums.start[i], start[i], 1e-15) << i;
    EXPECT_NEAR(sums.end[i], end[i], 1e-15) << i;
  }
}

TEST(Engagement, IsTheSumOverManyPlaces) {
  IntervalParts parts;
  AddRandom(IntervalParts::kRoom, parts);
  const Sums sums = Integrate(parts);
  double largest = 0;
  for (std::size_t i = 0; i < parts.size; ++i) {
    constexpr int kPlaces = 20000;
    const double length = parts.t_b[i] - parts.t_a[i];
    double start = 0;
    double end = 0;
    for (int n = 0; n < kPlaces; ++n) {
      const double s = (n + 0.5) / kPlaces;
      const double whole = parts.whole_a_mm[i] + s * (parts.whole_b_mm[i] - parts.whole_a_mm[i]);
      const double cut = parts.cut_a_mm[i] + s * (parts.cut_b_mm[i] - parts.cut_a_mm[i]);
      const double engaged =
          std::clamp(0.5 - whole / kDepths.entry_mm, 0.0, 1.0) * std::clamp(-cut / kDepths.look_ahead_mm, 0.0, 1.0);
      const double t = parts.t_a[i] + s * length;
      start += engaged * (1 - t) * length / kPlaces;
      end += engaged * t * length / kPlaces;
    }
    // The sum errs where the engagement bends. Its slope changes there by at most 0.06 / 0.005 = 12 per part, so that
    // each of the four bends adds at most 12 / 8 / kPlaces^2, and the curvature between them less.
    EXPECT_NEAR(sums.start[i], start, 1e-7) << i;
    EXPECT_NEAR(sums.end[i], end, 1e-7) << i;
    largest = std::max(largest, sums.end[i]);
  }
  EXPECT_GT(largest, 0.1);
}

TEST(Engagement, HasTheSameBitsAtEveryVectorWidthAndDoesNotAllocate) {
  // Counts that do not fill the vectors, too.
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}, IntervalParts::kRoom}) {
    IntervalParts parts;
    AddRandom(count, parts);
    const Sums expected = Integrate(parts);
    for (const std::string& target : VectorTargets()) {
      SetVectorTarget(target);
      const Sums sums = Integrate(parts);
      EXPECT_EQ(sums.start, expected.start) << target << ", " << count;
      EXPECT_EQ(sums.end, expected.end) << target << ", " << count;
    }
    SetVectorTarget("");
    const HeapGuard guard;
    Integrate(parts);
  }
}

}  // namespace
}  // namespace kerf
