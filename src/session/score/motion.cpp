#include "session/score/motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <optional>
#include <span>
#include <variant>

#include "base/core/spectrum.h"
#include "session/score/feed_meter.h"
#include "session/score/holes.h"

namespace kerf {
namespace {

constexpr double kRow_s = 0.004;
/// Events of the same kind that are closer in time count as one.
constexpr double kApart_s = 0.3;
/// An attempt begins when the tool has moved or turned by this much, or when the spindle has turned for this time: in
/// recordings of earlier versions, a session in a window begins with a spindle that is stopped after some ticks.
constexpr double kBegun_mm = 0.5;
constexpr double kBegun_rad = 0.02;
constexpr double kBegun_s = 0.05;
/// Averaging time for path length and speed, which smooths the encoders' steps.
constexpr double kBlock_s = 0.02;
constexpr double kSmooth_s = 0.2;
/// Period of the tremor, over which its mean is 0.
constexpr double kJitter_s = 0.1;
/// A pass beyond the far side begins at this distance beyond it and ends at half that distance.
constexpr double kPass_mm = 0.1;
constexpr double kNear_mm = 2;
/// A drill further than this from the axis of a hole is not in it.
constexpr double kBesideHole_mm = 8;
/// Largest angle between the axes of a drill in its hole.
constexpr double kSameAxis_rad = 0.1;
/// A bur is at a place of the line if its tip is at most this far beside the wanted plane, and from it along the line.
constexpr double kBesideLine_mm = 8;
constexpr double kAtPlace_mm = 0.5;
/// Feed along the line below which the tool rests.
constexpr double kRest_mm_per_s = 0.1;
/// The distance to the nerve is computed once per this number of rows.
constexpr std::size_t kNerveRows = 5;
/// SPARC: frequency limit, and fraction of the largest amplitude below which the spectrum ends.
constexpr double kSparc_Hz = 20;
constexpr double kSparcFraction = 0.05;

/// Mean position over a block of time.
struct Block {
  Vec3 p_W{0};
  double time_s = 0;
  bool contact = false;
};

/// Returns the negative arc length of the normalised amplitude spectrum of a speed sampled every kBlock_s.
double CalcSparc(const std::vector<double>& speed) {
  std::size_t size = 4;
  while (size < 4 * speed.size()) size *= 2;
  std::vector<double> padded(size, 0);
  std::copy(speed.begin(), speed.end(), padded.begin() + static_cast<std::ptrdiff_t>((size - speed.size()) / 2));
  const std::vector<double> amplitudes = CalcAmplitudes(padded);
  const double largest = *std::max_element(amplitudes.begin(), amplitudes.end());
  if (!(largest > 0)) return 0;
  const double step_Hz = 1 / (kBlock_s * static_cast<double>(size));
  const auto count = std::min(amplitudes.size(), static_cast<std::size_t>(kSparc_Hz / step_Hz) + 1);
  std::size_t last = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (amplitudes[i] >= kSparcFraction * largest) last = i;
  }
  double length = 0;
  for (std::size_t i = 1; i <= last; ++i) {
    length += std::hypot(1.0 / static_cast<double>(last), (amplitudes[i] - amplitudes[i - 1]) / largest);
  }
  return -length;
}

bool IsSame(const Pose& a, const Pose& b) {
  return a.p_AB == b.p_AB && a.R_AB == b.R_AB;
}

/// Returns the direction of a drill into the bone.
Vec3 DrillDirection(const Pose& X_WT) {
  return X_WT.R_AB * Vec3(0, 0, -1);
}

/// Returns true if the drill at `X_WT` has nearly the axis that it has at `X_axis_WT`: its tip is at most `radius_mm`
/// beside it.
bool IsOnAxis(const Pose& X_axis_WT, const Pose& X_WT, double radius_mm) {
  const Vec3 axis_W = DrillDirection(X_axis_WT);
  const Vec3 d_W = X_WT.p_AB - X_axis_WT.p_AB;
  return glm::dot(axis_W, DrillDirection(X_WT)) >= std::cos(kSameAxis_rad) &&
         glm::length(d_W - glm::dot(d_W, axis_W) * axis_W) <= radius_mm;
}

/// Returns the index of the hole whose axis is nearest to the drill's tip, of those along which it points; the number
/// of holes: it is beside all of them.
std::size_t FindNearestHole(const std::vector<WantedCut>& holes, const Pose& X_WT) {
  std::size_t nearest = holes.size();
  double least_mm = kBesideHole_mm;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    const Vec3 tip = holes[i].ToCut(X_WT.p_AB);
    const double distance_mm = std::hypot(tip.x, tip.z);
    if (distance_mm >= least_mm || !(glm::dot(DrillDirection(X_WT), holes[i].into_W) > 0)) continue;
    least_mm = distance_mm;
    nearest = i;
  }
  return nearest;
}

/// Returns an upper bound of the displacement of a body's points from one pose to another, mm. A rotation by the angle
/// a moves a point by at most 2 sin(a/2) times its distance, and the difference of the quaternions is 2 sin(a/4).
double CalcLargestDisplacement(const Pose& from, const Pose& to, double reach_mm) {
  const Quat& p = from.R_AB;
  const Quat& q = to.R_AB;
  const double sign = glm::dot(p, q) < 0 ? -1 : 1;
  const double difference =
      std::sqrt((p.w - sign * q.w) * (p.w - sign * q.w) + (p.x - sign * q.x) * (p.x - sign * q.x) +
                (p.y - sign * q.y) * (p.y - sign * q.y) + (p.z - sign * q.z) * (p.z - sign * q.z));
  constexpr double kRounding_mm = 1e-6;
  return glm::distance(from.p_AB, to.p_AB) + 2 * difference * reach_mm + kRounding_mm;
}

/// Returns cumulative sums, for means over any interval.
std::vector<Vec3> CalcCumulativeSums(std::span<const Vec3> p) {
  std::vector<Vec3> sums(p.size() + 1, Vec3(0));
  for (std::size_t i = 0; i < p.size(); ++i) sums[i + 1] = sums[i] + p[i];
  return sums;
}

}  // namespace

void MotionMeter::FindBeginning(const MotionTick& tick) {
  const double from_s = std::max(tick.time_s - tick.dt_s, 0.0);
  if (!X_first_) X_first_ = tick.X_WT;
  if (!tick.turns) turning_since_s_.reset();
  if (tick.turns && !turning_since_s_) turning_since_s_ = from_s;
  const double cos_half = std::abs(glm::dot(X_first_->R_AB, tick.X_WT.R_AB));
  const bool moved = glm::distance(X_first_->p_AB, tick.X_WT.p_AB) > kBegun_mm || cos_half < std::cos(0.5 * kBegun_rad);
  const bool turns = turning_since_s_ && tick.time_s >= *turning_since_s_ + kBegun_s;
  if (moved || turns) begun_s_ = turning_since_s_.value_or(from_s);
}

void MotionMeter::Take(const MotionTick& tick) {
  end_s_ = std::max(end_s_, tick.time_s);
  if (!begun_s_) FindBeginning(tick);
  if (tick.contact) {
    contact_s_ += tick.dt_s;
    force_sum_ += tick.force_N * tick.dt_s;
    force2_sum_ += tick.force_N * tick.force_N * tick.dt_s;
    if (tick.time_s - left_s_ > kApart_s) ++strokes_;
    left_s_ = tick.time_s;
  }
  force_peak_N_ = std::max(force_peak_N_, tick.force_N);
  if (force_limit_N_ > 0 && tick.force_N > force_limit_N_) force_over_s_ += tick.dt_s;
  for (std::size_t id = 0; id < cuts_.size(); ++id) {
    if ((tick.regions_cut[id / 64] >> (id % 64) & 1) == 0) continue;
    if (tick.time_s - cuts_[id].last_s > kApart_s) ++cuts_[id].count;
    cuts_[id].last_s = tick.time_s;
  }
  row_ = {tick.time_s, tick.X_WT, tick.contact || (any_ && row_.contact), tick.turns, tick.force_N};
  any_ = true;
  if (tick.time_s + 1e-9 < next_s_) return;
  rows_.push_back(row_);
  row_.contact = false;
  next_s_ = tick.time_s + kRow_s;
}

void MotionMeter::MeasureForces(ScoreSheet& sheet) const {
  SetValue(sheet, "force_peak_N", force_peak_N_);
  if (contact_s_ > 0) {
    SetValue(sheet, "force_mean_N", force_sum_ / contact_s_);
    SetValue(sheet, "force_rms_N", std::sqrt(force2_sum_ / contact_s_));
  }
  if (force_limit_N_ > 0) SetValue(sheet, "force_over_s", force_over_s_);
}

void MotionMeter::MeasureMotion(ScoreSheet& sheet) const {
  std::vector<Block> blocks;
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < rows_.size();) {
    Block block;
    std::size_t k = i;
    for (; k < rows_.size() && rows_[k].time_s < rows_[i].time_s + kBlock_s - 1e-9; ++k) {
      block.p_W += rows_[k].X_WT.p_AB;
      block.contact = block.contact || rows_[k].contact;
    }
    block.p_W /= static_cast<double>(k - i);
    block.time_s = 0.5 * (rows_[i].time_s + rows_[k - 1].time_s);
    blocks.push_back(block);
    i = k;
  }
  double path_mm = 0;
  std::vector<double> speed;
  std::vector<double> feed;
  const auto half = static_cast<std::size_t>(std::lround(0.5 * kSmooth_s / kBlock_s));
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    const double distance_mm = glm::distance(blocks[i].p_W, blocks[i - 1].p_W);
    const double dt_s = blocks[i].time_s - blocks[i - 1].time_s;
    path_mm += distance_mm;
    speed.push_back(dt_s > 0 ? distance_mm / dt_s : 0);
    const std::size_t a = i > half ? i - half : 0;
    const std::size_t b = std::min(i + half, blocks.size() - 1);
    const double over_s = blocks[b].time_s - blocks[a].time_s;
    if (blocks[i].contact && over_s > 0) feed.push_back(glm::distance(blocks[b].p_W, blocks[a].p_W) / over_s);
  }
  SetValue(sheet, "path_length_mm", path_mm);
  if (speed.size() >= 4) SetValue(sheet, "sparc", CalcSparc(speed));
  if (feed.empty()) return;
  double mean = 0;
  for (const double f : feed) mean += f / static_cast<double>(feed.size());
  double variance = 0;
  for (const double f : feed) variance += (f - mean) * (f - mean) / static_cast<double>(feed.size());
  SetValue(sheet, "feed_mean_mm_per_s", mean);
  if (mean > 0) SetValue(sheet, "feed_cv", std::sqrt(variance) / mean);

  for (const Row& row : rows_) places.push_back(row.X_WT.p_AB);
  const std::vector<Vec3> sums = CalcCumulativeSums(places);
  // Number of rows on either side of the middle one, so that together they span kJitter_s.
  const auto side = static_cast<std::size_t>(0.5 * kJitter_s / kRow_s);
  std::vector<double> jitter_mm;
  for (std::size_t i = side; i + side < rows_.size(); ++i) {
    if (!rows_[i].contact) continue;
    const Vec3 mean_W = (sums[i + side + 1] - sums[i - side]) / static_cast<double>(2 * side + 1);
    jitter_mm.push_back(glm::distance(places[i], mean_W));
  }
  if (jitter_mm.empty()) return;
  const auto middle = jitter_mm.begin() + static_cast<std::ptrdiff_t>(jitter_mm.size() / 2);
  std::nth_element(jitter_mm.begin(), middle, jitter_mm.end());
  SetValue(sheet, "jitter_mm", *middle);
}

void MotionMeter::MeasureLine(std::span<const DepthGauge> gauges, ScoreSheet& sheet) const {
  std::vector<std::vector<double>> deepest_mm;
  for (const DepthGauge& gauge : gauges) {
    std::vector<double>& deepest = deepest_mm.emplace_back(gauge.columns().size(), -kAbove_mm);
    std::optional<Pose> last;
    for (const Row& row : rows_) {
      if (!row.contact || (last && IsSame(*last, row.X_WT))) continue;
      last = row.X_WT;
      gauge.TakeDepths(row.X_WT, deepest);
    }
  }
  SetValue(sheet, "line_share", CalcLineShare(gauges, deepest_mm));
}

/// A saw that is stopped counts too, other than in the mean feed in contact: it cuts nothing.
void MotionMeter::MeasureFeedAlong(const WantedCut& cut, ScoreSheet& sheet) const {
  FeedMeter meter(cut);
  FeedAlong along{.slowest_mm_per_s = 1e300};
  double error_sum = 0;
  double count = 0, slow = 0, fast = 0, rests = 0;  // of rows
  for (const Row& row : rows_) {
    const std::optional<double> feed = meter.Take(row.time_s, row.X_WT);
    if (!feed) continue;
    const double error = *feed / sheet.exercise.feed_mm_per_s - 1;
    error_sum += std::abs(error);
    ++count;
    along.slowest_mm_per_s = std::min(along.slowest_mm_per_s, *feed);
    along.fastest_mm_per_s = std::max(along.fastest_mm_per_s, *feed);
    along.mean_mm_per_s += *feed;
    if (error > kFeedGood) ++fast;
    if (error >= -kFeedGood) continue;
    ++slow;
    if (*feed < kRest_mm_per_s) ++rests;
    if (*feed >= kRest_mm_per_s) along.slow_force_N += row.force_N;
  }
  if (count == 0) return;
  along.mean_mm_per_s /= count;
  along.slow_share = slow / count;
  along.fast_share = fast / count;
  along.rest_share = rests / count;
  if (slow > rests) along.slow_force_N /= slow - rests;
  sheet.feed_along = along;
  SetValue(sheet, "feed_error", error_sum / count);
  // A planned cut has no line to follow.
  if (sheet.kind != ExerciseKind::kOsteotomy) SetValue(sheet, "feed_mean_mm_per_s", along.mean_mm_per_s);
}

void MotionMeter::MeasurePlunge(const DepthGauge& gauge, ScoreSheet& sheet) const {
  if (gauge.columns().empty()) return;
  double largest_mm = 0;
  double pass_mm = 0;
  double sum_mm = 0;
  int passes = 0;
  const auto end_pass = [&] {
    if (pass_mm <= 0) return;
    sum_mm += pass_mm;
    ++passes;
    pass_mm = 0;
  };
  std::optional<Pose> last;
  double beyond_mm = -1;
  for (const Row& row : rows_) {
    if (!last || !IsSame(*last, row.X_WT)) {
      last = row.X_WT;
      const std::optional<DepthReading> reading = gauge.Calc(row.X_WT);
      beyond_mm = reading ? reading->beyond_mm : -1;
    }
    largest_mm = std::max(largest_mm, beyond_mm);
    if (beyond_mm >= kPass_mm) pass_mm = std::max(pass_mm, beyond_mm);
    if (beyond_mm < 0.5 * kPass_mm) end_pass();
  }
  end_pass();
  SetValue(sheet, "plunge_max_mm", largest_mm);
  SetValue(sheet, "plunge_mean_mm", passes > 0 ? sum_mm / passes : 0);
  SetValue(sheet, "plunges", passes);
}

void MotionMeter::MeasureNerve(const Tool& tool, const RegionDistance& nerve, ScoreSheet& sheet) const {
  double min_mm = 1e9;
  double near_s = 0;
  // The pose and the distance that were computed last. No point of the tool is nearer to the nerve than this distance
  // minus the point's displacement since, so that poses that cannot change a measure are left out.
  std::optional<Pose> last;
  double distance_mm = 0;
  const double reach_mm = CalcReach(tool);
  for (std::size_t i = 0; i < rows_.size(); i += kNerveRows) {
    if (!rows_[i].turns) continue;
    const Pose& X_WT = rows_[i].X_WT;
    if (last && distance_mm - CalcLargestDisplacement(*last, X_WT, reach_mm) > std::max(kNear_mm, min_mm)) continue;
    if (!last || !IsSame(*last, X_WT)) {
      last = X_WT;
      distance_mm = nerve.Calc(tool, X_WT);
    }
    min_mm = std::min(min_mm, distance_mm);
    if (distance_mm < kNear_mm && i > 0) near_s += rows_[i].time_s - rows_[i - kNerveRows].time_s;
  }
  if (min_mm < 1e8) SetValue(sheet, "nerve_distance_mm", min_mm);
  SetValue(sheet, "near_miss_s", near_s);
}

std::vector<std::optional<Pose>> MotionMeter::FindDeepest(const Bone& before,
                                                          const std::vector<WantedCut>& holes) const {
  const PhiSampler phi(before);
  std::vector<std::optional<Pose>> deepest(holes.size());
  std::vector<std::optional<Pose>> touched(holes.size());  // the last of these poses in contact
  std::vector<double> deepest_mm(holes.size(), -kAbove_mm);
  for (const Row& row : rows_) {
    const std::size_t nearest = FindNearestHole(holes, row.X_WT);
    if (nearest == holes.size()) continue;
    const WantedCut& hole = holes[nearest];
    const double depth_mm = hole.ToCut(row.X_WT.p_AB).y;
    if (depth_mm <= deepest_mm[nearest]) continue;
    const bool touches = row.contact && row.turns;
    // A drill that has passed through the bone touches nothing in its own hole.
    const bool is_inside = touched[nearest] && IsOnAxis(*touched[nearest], row.X_WT, 0.5 * hole.thickness_mm);
    if (!touches && !is_inside) continue;
    if (!MeasureHole(phi, hole, row.X_WT)) continue;
    deepest_mm[nearest] = depth_mm;
    deepest[nearest] = row.X_WT;
    if (touches) touched[nearest] = row.X_WT;
  }
  return deepest;
}

std::vector<std::optional<double>> MotionMeter::FindLeans_deg(std::span<const DepthGauge> gauges) const {
  struct Place {
    double depth_mm = 0;
    double lean_deg = 0;
  };
  std::vector<std::optional<double>> leans_deg(gauges.size());
  if (gauges.empty() || !gauges.front().cut().solid) return leans_deg;  // all cuts are made with one tool
  std::vector<std::vector<Place>> places;
  for (const DepthGauge& gauge : gauges) places.emplace_back(gauge.columns().size());
  std::optional<Pose> last;
  for (const Row& row : rows_) {
    if (!row.contact || !row.turns || (last && IsSame(*last, row.X_WT))) continue;
    last = row.X_WT;
    const DepthGauge& gauge = FindNearestGauge(gauges, row.X_WT);
    const WantedCut& cut = gauge.cut();
    const std::vector<CutColumn>& columns = gauge.columns();
    const Vec3 axis_W = DrillDirection(row.X_WT);
    if (columns.empty()) continue;
    const Vec3 tip = cut.ToCut(cut.FindLowest(row.X_WT));
    if (std::abs(tip.z) > kBesideLine_mm) continue;
    auto at = std::lower_bound(columns.begin(), columns.end(), tip.x,
                               [](const CutColumn& column, double s_mm) { return column.s_mm < s_mm; });
    if (at == columns.end() || (at != columns.begin() && tip.x - std::prev(at)->s_mm < at->s_mm - tip.x)) --at;
    if (std::abs(at->s_mm - tip.x) > kAtPlace_mm) continue;
    const double depth_mm = tip.y - at->near_mm;
    Place& place =
        places[static_cast<std::size_t>(&gauge - gauges.data())][static_cast<std::size_t>(at - columns.begin())];
    if (depth_mm <= place.depth_mm) continue;
    // An axis across the bone, or out of it, leans by a right angle.
    const double across = glm::dot(axis_W, cut.across_W);
    const double into = glm::dot(axis_W, cut.into_W);
    const double lean_deg = into > 0 ? std::atan2(across, into) * kDegreesPerRad : std::copysign(90.0, across);
    place = {depth_mm, -lean_deg};
  }
  for (std::size_t i = 0; i < gauges.size(); ++i) {
    double sum_deg = 0;
    int count = 0;
    for (std::size_t k = 0; k < places[i].size(); ++k) {
      const CutColumn& column = gauges[i].columns()[k];
      const double wanted_mm = std::min(gauges[i].cut().depth_mm, column.far_mm - column.near_mm);
      if (!(places[i][k].depth_mm > 0) || places[i][k].depth_mm < kCoveredFraction * wanted_mm) continue;
      sum_deg += places[i][k].lean_deg;
      ++count;
    }
    if (count > 0) leans_deg[i] = sum_deg / count;
  }
  return leans_deg;
}

void MotionMeter::Finish(const Tool& tool, std::span<const DepthGauge> gauges, const RegionDistance* nerve,
                         const std::array<bool, 256>& nerve_regions, ScoreSheet& sheet) const {
  SetValue(sheet, "time_total_s", end_s_ - begun_s_.value_or(0));
  sheet.turned = std::any_of(rows_.begin(), rows_.end(), [](const Row& r) { return r.turns; });
  SetValue(sheet, "time_active_s", contact_s_);
  SetValue(sheet, "strokes", strokes_);
  MeasureForces(sheet);
  MeasureMotion(sheet);
  if (!gauges.empty()) MeasureLine(gauges, sheet);
  if (gauges.size() == 1) MeasureFeedAlong(gauges.front().cut(), sheet);
  if (gauges.size() == 1) MeasurePlunge(gauges.front(), sheet);
  if (nerve == nullptr || nerve->empty()) return;
  MeasureNerve(tool, *nerve, sheet);
  int breaches = 0;
  for (std::size_t id = 0; id < cuts_.size(); ++id) breaches += nerve_regions[id] ? cuts_[id].count : 0;
  SetValue(sheet, "breaches", breaches);
}

}  // namespace kerf
