#include "cut/contact/edge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kerf {
namespace {

constexpr int kMaxHalvings = 4;  // maximum number of halvings of an interval in which the engagement changes
constexpr std::size_t kIntervalsAtOnce = 32;
constexpr double kNotInContact = std::numeric_limits<double>::infinity();  // distance
constexpr double kChange = 0.1;  // change of engagement above which an interval is halved

const CuttingPoint kEmptyPoint{};

/// Returns the fraction of a tooth's look-ahead that is filled with bone.
double Engagement(double distance_mm, double look_ahead_mm) {
  return distance_mm < 0 ? std::min(-distance_mm / look_ahead_mm, 1.0) : 0;
}

}  // namespace

Edge::Edge(const BoneField& field, const Bone& bone, const Tool& tool, const ToolShape& shape, const Vec3& p_EC_mm)
    : field_(field),
      materials_(bone, tool),
      osteons_W_(bone.materials().osteon_direction()),
      p_EC_(p_EC_mm),
      motion_(shape.motion),
      look_ahead_mm_(kLookAheadVoxels * field.voxel_mm()),
      entry_mm_(kEntryVoxels * field.voxel_mm()),
      deep_mm_(-2 * field.voxel_mm()),
      material_ahead_mm_(kMaterialAheadVoxels * field.voxel_mm()),
      region_step_mm_(bone.region_voxel_mm()),
      has_metal_(field.has_metal()),
      reach_mm_(shape.reach_mm + look_ahead_mm_),
      ring_radius_mm_(shape.edge_form == EdgeForm::kRing ? glm::length(shape.edge.front().p_T) : 0),
      is_chain_(shape.edge_form == EdgeForm::kChain),
      ring_step_rad_(ring_radius_mm_ > 0 ? 2 * std::numbers::pi / static_cast<double>(shape.edge.size()) : 0),
      tooth_points_(shape.edge.size()),
      penetration_(shape.edge.size() + shape.solids.size()) {
  points_.reserve(shape.edge.size() + shape.solids.size());
  const double rad_per_pass = 2 * std::numbers::pi / shape.passes_per_turn;
  for (const EdgePoint& p : shape.edge) {
    const Twist along = ring_radius_mm_ > 0 ? MakeRow(Vec3(-p.e_T.y, p.e_T.x, 0), p.p_T - p_EC_) : Twist{};
    points_.push_back(
        {p.p_T + look_ahead_mm_ * p.e_T, p.e_T, p.p_T, p.teeth, along, rad_per_pass * std::hypot(p.p_T.x, p.p_T.y)});
  }
  for (const FacePoint& p : shape.solids) {
    points_.push_back({p.p_T, p.n_T, p.p_T, 0, {}, 0, p.touching});
    if (p.touching == Touching::kMoving) held_.push_back(p);
  }
  if (is_joined()) spacing_mm_ = 1.01 * glm::length(points_[1].ahead_T - points_[0].ahead_T);
  distance_.resize(points_.size());
  bound_.resize(tooth_points_);
  solid_distance_.resize(points_.size());
  sampled_.resize(std::max(points_.size(), kIntervalsAtOnce << kMaxHalvings));
  sampled_cut_.resize(sampled_.size());
  ahead_.resize(tooth_points_);
  uniform_regions_.resize(tooth_points_);
  uniform_E_MPa_.resize(tooth_points_);
  uniform_E_star_MPa_.resize(tooth_points_);
  constexpr std::size_t kMaxHalves = kIntervalsAtOnce << kMaxHalvings;
  parts_.reserve(kMaxHalves);
  halves_.reserve(kMaxHalves);
  list_.Reserve(std::max(points_.size(), kMaxHalves));
  to_look_.reserve(points_.size());
  near_surface_.reserve(points_.size());
  intervals_.reserve(tooth_points_);
  engaged_.reserve(tooth_points_);
  looked_at_mm_.resize(points_.size());
  Forget();
  fraction_.resize(points_.size());
  after_.resize(points_.size());
  contacts_.reserve(points_.size());
  found_.reserve(points_.size());
}

void Edge::SetDisplacement(double slide_mm) {
  if (slide_mm == slide_mm_) return;
  p_EC_ = motion_.Move(p_EC_, slide_mm_ - slide_mm);
  slide_mm_ = slide_mm;
  R_TE_ = motion_.CalcTurn(slide_mm);
  const Quat back = motion_.CalcTurn(-slide_mm);
  for (std::size_t i = 0; i < held_.size(); ++i) {
    Point& point = points_[points_.size() - held_.size() + i];
    point.p_T = point.ahead_T = motion_.Move(held_[i].p_T, -slide_mm, back);
    point.e_T = back * held_[i].n_T;
  }
}

/// Samples both fields at points into sampled_ and sampled_cut_.
void Edge::SampleParts(const Probe& probe, const PointList& points) {
  samples_ += points.size();
  probe.Parts(points, sampled_.data(), sampled_cut_.data());
}

/// Looks at the points in to_look_.
void Edge::Look(const Probe& probe) {
  const std::size_t count = to_look_.size();
  const auto point = [this](std::size_t n) { return static_cast<std::size_t>(to_look_[n]); };
  list_.Clear();
  for (std::size_t n = 0; n < count; ++n) list_.Add(points_[point(n)].ahead_T);
  SampleParts(probe, list_);
  near_surface_.clear();
  list_.Clear();
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t i = point(n);
    ahead_[i] = {sampled_[n], sampled_cut_[n]};
    // The surface is between the point and the place in front of it, or at most as far from the latter.
    if (sampled_[n] > deep_mm_) {
      near_surface_.push_back(static_cast<int>(i));
      list_.Add(points_[i].p_T);
    }
  }
  SampleParts(probe, list_);
  for (std::size_t n = 0; n < near_surface_.size(); ++n) {
    ahead_[static_cast<std::size_t>(near_surface_[n])].whole_mm = sampled_[n];
  }
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t i = point(n);
    bound_[i] = distance_[i] = CalcDistance(ahead_[i]);
    looked_at_mm_[i] = travelled_mm_;
  }
}

/// Sets bound_, and lists in to_look_ the points nearer to bone than half their distance from each other.
void Edge::SetBounds() {
  // Copies, because the compiler must take any number for one that is written through a pointer.
  const std::size_t count = tooth_points_;
  const double travelled_mm = travelled_mm_;
  const double* const distance = distance_.data();
  const double* const looked_at = looked_at_mm_.data();
  double* const bound = bound_.data();
  for (std::size_t i = 0; i < count; ++i) bound[i] = distance[i] - kMaxGradient * (travelled_mm - looked_at[i]);
  const double near_mm = 0.5 * spacing_mm_ * stride_;
  to_look_.resize(count);
  int* end = to_look_.data();
  for (std::size_t i = 0; i < count; i += static_cast<std::size_t>(stride_)) {
    *end = static_cast<int>(i);
    end += bound[i] < near_mm ? 1 : 0;
  }
  to_look_.resize(static_cast<std::size_t>(end - to_look_.data()));
}

void Edge::FindTeeth(const Probe& probe, StepProblem& problem) {
  problem.cutting.clear();
  const bool jumps = ring_radius_mm_ > 0 && problem.law.jumps;
  problem.arc_rad = jumps ? stride_ * ring_step_rad_ : 0;
  contacts_.clear();
  found_.clear();
  met_metal_ = false;
  travelled_mm_ += std::max(CalcTravel(X_looked_, probe.X_WT(), reach_mm_), 1e-9);  // > 0: bone may have been removed
  X_looked_ = probe.X_WT();
  const std::size_t stride = static_cast<std::size_t>(stride_);
  SetBounds();
  Look(probe);
  std::fill(fraction_.begin(), fraction_.end(), 0.0);
  if (is_joined()) {
    FractionIntervals(probe);
  } else {
    for (const int looked_at : to_look_) {
      const auto i = static_cast<std::size_t>(looked_at);
      fraction_[i] = CalcEntered(ahead_[i].whole_mm) * Engagement(ahead_[i].cut_mm, look_ahead_mm_);
    }
  }
  engaged_.clear();
  list_.Clear();
  for (std::size_t i = 0; i < tooth_points_; i += stride) {
    if (!(fraction_[i] > 0)) continue;
    engaged_.push_back(static_cast<int>(i));
    list_.Add(CalcMaterialPoint(i));
  }
  probe.InterpolateUniform(list_, materials_.moduli(), uniform_regions_.data(), uniform_E_MPa_.data(),
                           uniform_E_star_MPa_.data());
  for (std::size_t n = 0; n < engaged_.size(); ++n) {
    const auto i = static_cast<std::size_t>(engaged_[n]);
    // Filled in place: a point is large, and there are hundreds of them in a tick. A copy of an empty one is faster
    // than emplace_back(), which clears its memory with a slow instruction.
    problem.cutting.push_back(kEmptyPoint);
    CuttingPoint& point = problem.cutting.back();
    int region = uniform_regions_[n];
    if (!materials_.SetUniform(region, uniform_E_MPa_[n], uniform_E_star_MPa_[n], problem.law.reads, point.cut)) {
      region = FindMaterial(probe, i, problem.law.reads, point.cut);
    }
    if (region == 0) {
      problem.cutting.pop_back();
      continue;
    }
    point.row = MakeRow(Turn(points_[i].e_T), Turn(points_[i].p_T - p_EC_));
    point.teeth = fraction_[i] * points_[i].teeth * stride_;
    point.along = points_[i].along;
    if (jumps) point.after_fraction = after_[i] / fraction_[i];
    point.cut.speed_mm_per_s = is_chain_ ? problem.edge_mm_per_s : problem.passes_per_s * points_[i].mm_per_pass;
    if ((problem.law.reads & kReadsOsteons) != 0) point.cut.osteon = CalcOsteonShares(probe, i);
    contacts_.push_back({region, static_cast<int>(i)});
  }
  if (has_metal_) DropPointsAtMetal(probe, problem);
}

/// Takes the points in front of metal out of the problem.
void Edge::DropPointsAtMetal(const Probe& probe, StepProblem& problem) {
  std::size_t kept = 0;
  for (std::size_t n = 0; n < contacts_.size(); ++n) {
    if (IsAtMetal(probe, points_[static_cast<std::size_t>(contacts_[n].point)])) {
      met_metal_ = true;
      continue;
    }
    contacts_[kept] = contacts_[n];
    problem.cutting[kept++] = problem.cutting[n];
  }
  contacts_.resize(kept);
  problem.cutting.resize(kept);
}

/// Sets the engaged parts of the intervals between neighbours.
void Edge::FractionIntervals(const Probe& probe) {
  const std::size_t stride = static_cast<std::size_t>(stride_);
  const double length = spacing_mm_ * stride_;
  // If the distances of two neighbours from the bone add up to at least their distance from each other, there is no
  // bone between them.
  std::fill(after_.begin(), after_.end(), 0.0);
  intervals_.clear();
  to_look_.clear();
  const auto look = [this](std::size_t i) {
    if (looked_at_mm_[i] == travelled_mm_) return;
    looked_at_mm_[i] = travelled_mm_;
    to_look_.push_back(static_cast<int>(i));
  };
  for (std::size_t a = 0; a < tooth_points_; a += stride) {
    const std::size_t b = NextOf(a);
    if (b == a || (bound_[a] >= 0 && bound_[b] >= 0 && bound_[a] + bound_[b] >= length)) continue;
    intervals_.push_back(static_cast<int>(a));
    look(a);
    look(b);
  }
  Look(probe);
  for (std::size_t first = 0; first < intervals_.size(); first += kIntervalsAtOnce) {
    Fraction(probe, std::span(intervals_).subspan(first, std::min(kIntervalsAtOnce, intervals_.size() - first)));
  }
}

Edge::Place Edge::MakePlace(double t, const Ahead& at) const {
  return {t, at, CalcDistance(at), Engagement(at.cut_mm, look_ahead_mm_)};
}

/// Adds the engaged part of some intervals between neighbours to both ends: integrates engagement times the hat
/// function of each end.
void Edge::Fraction(const Probe& probe, std::span<const int> intervals) {
  parts_.clear();
  for (const int interval : intervals) {
    const auto a = static_cast<std::size_t>(interval);
    parts_.push_back({interval, MakePlace(0, ahead_[a]), MakePlace(1, ahead_[NextOf(a)])});
  }
  for (int halvings = 0; !parts_.empty(); ++halvings) {
    halves_.clear();
    list_.Clear();
    for (const Part& part : parts_) {
      const Use use = FindUse(part, halvings);
      if (use == Use::kHalves) {
        AddHalf(part);
      } else if (use == Use::kWhole) {
        const std::size_t n = summed_.size++;
        summed_.interval[n] = part.interval;
        summed_.t_a[n] = part.a.t;
        summed_.t_b[n] = part.b.t;
        summed_.whole_a_mm[n] = part.a.at.whole_mm;
        summed_.whole_b_mm[n] = part.b.at.whole_mm;
        summed_.cut_a_mm[n] = part.a.at.cut_mm;
        summed_.cut_b_mm[n] = part.b.at.cut_mm;
        if (summed_.size == IntervalParts::kRoom) SumParts();
      }
    }
    SampleParts(probe, list_);
    for (std::size_t n = 0; n < halves_.size(); n += 2) {
      Place& middle = halves_[n].b;
      middle = halves_[n + 1].a = MakePlace(middle.t, {sampled_[n], sampled_cut_[n + 1]});
    }
    std::swap(parts_, halves_);
  }
  SumParts();
}

/// Returns whether a part of an interval is engaged, and whether its fields may be taken as linear.
Edge::Use Edge::FindUse(const Part& part, int halvings) const {
  const auto& [interval, a, b] = part;
  const bool out = a.distance_mm >= 0 && b.distance_mm >= 0;
  if (out && a.distance_mm + b.distance_mm >= (b.t - a.t) * spacing_mm_ * stride_) return Use::kNone;
  // Between two ends in air one sample is enough: the walls of a kerf are equally near along its whole length. The
  // surface of the whole bone is nearly flat within an interval.
  const bool crosses = (a.at.whole_mm < 0) != (b.at.whole_mm < 0) && std::max(a.engagement, b.engagement) > 0;
  const bool changes = std::abs(a.engagement - b.engagement) > kChange;
  if (out || (crosses && !changes) ? halvings < 1 : changes && halvings < kMaxHalvings) return Use::kHalves;
  return out ? Use::kNone : Use::kWhole;
}

/// Appends the halves of a part to halves_, and to list_ their middle: the point of the edge and the one in front of
/// it.
void Edge::AddHalf(const Part& part) {
  const auto i = static_cast<std::size_t>(part.interval);
  const Point& a = points_[i];
  const Point& b = points_[NextOf(i)];
  const double t = 0.5 * (part.a.t + part.b.t);
  if (is_chain_) {
    list_.Add((1 - t) * a.p_T + t * b.p_T);
    list_.Add((1 - t) * a.ahead_T + t * b.ahead_T);
  } else {
    const Vec3 e_T = glm::normalize((1 - t) * a.e_T + t * b.e_T);
    list_.Add(ring_radius_mm_ * e_T);
    list_.Add((ring_radius_mm_ + look_ahead_mm_) * e_T);
  }
  const Place middle{t, {}, 0, 0};
  halves_.push_back({part.interval, part.a, middle});
  halves_.push_back({part.interval, middle, part.b});
}

/// Adds the parts in summed_ to the ends of their intervals.
void Edge::SumParts() {
  double of_start[IntervalParts::kRoom];
  double of_end[IntervalParts::kRoom];
  IntegrateEngagement({entry_mm_, look_ahead_mm_}, summed_, of_start, of_end);
  for (std::size_t n = 0; n < summed_.size; ++n) {
    const auto a = static_cast<std::size_t>(summed_.interval[n]);
    fraction_[a] += of_start[n];
    after_[a] += of_start[n];
    fraction_[NextOf(a)] += of_end[n];
  }
  summed_.size = 0;
}

/// Returns the squared cosines between the osteons and the directions of a point of the edge. All are 0 if the
/// direction of the osteons is unknown, or on the spindle's axis.
OsteonShares Edge::CalcOsteonShares(const Probe& probe, std::size_t i) const {
  if (!osteons_W_) return {};
  const Point& point = points_[i];
  const Vec3 osteons_T = probe.X_WT().InverseVector(*osteons_W_);
  if (is_chain_) {
    const double along = glm::dot(osteons_T, Vec3(-point.e_T.y, point.e_T.x, 0));
    const double into = glm::dot(osteons_T, point.e_T);
    return {along * along, into * into, osteons_T.z * osteons_T.z};
  }
  const double radius_mm = std::hypot(point.p_T.x, point.p_T.y);
  if (!(radius_mm > 0)) return {};
  const double along = glm::dot(osteons_T, Vec3(-point.p_T.y, point.p_T.x, 0)) / radius_mm;
  const double into = glm::dot(osteons_T, point.e_T);
  return {along * along, into * into, std::max(0.0, 1 - along * along - into * into)};
}

int Edge::FindMaterial(const Probe& probe, std::size_t i, unsigned reads, ToothCut& cut) const {
  const auto at = [&](const Vec3& p_T) { return materials_.Find(field_, probe.World(p_T), reads, cut); };
  if (const int region = at(CalcMaterialPoint(i))) return region;
  if (const int region = at(points_[i].ahead_T)) return region;
  // Coarse region voxels can have their centres outside the bone: look further inside.
  if (const int region = at(points_[i].ahead_T + region_step_mm_ * points_[i].e_T)) return region;
  if (!is_joined()) return 0;
  // The point is just outside the bone, but an interval next to it reaches inside: use the material of the deeper
  // neighbour.
  const std::size_t stride = static_cast<std::size_t>(stride_);
  const std::size_t next = NextOf(i);
  const std::size_t last = i > 0 ? i - stride : is_chain_ ? i : (tooth_points_ - 1) / stride * stride;
  if (next == i || last == i) return at(points_[next == i ? last : next].ahead_T);
  return at(points_[distance_[next] < distance_[last] ? next : last].ahead_T);
}

/// Sets solid_distance_ by samples at the points that are `wanted(i)`, listed in to_look_, and to kNotInContact
/// elsewhere.
template <typename Wanted>
void Edge::SampleSolids(const Probe& probe, Wanted&& wanted) {
  to_look_.clear();
  list_.Clear();
  std::fill(solid_distance_.begin(), solid_distance_.end(), kNotInContact);
  for (std::size_t i = 0; i < points_.size(); i += static_cast<std::size_t>(stride_)) {
    if (!wanted(i)) continue;
    to_look_.push_back(static_cast<int>(i));
    list_.Add(points_[i].p_T);
  }
  samples_ += list_.size();
  probe.Distances(list_, sampled_.data());
  for (std::size_t n = 0; n < to_look_.size(); ++n) {
    solid_distance_[static_cast<std::size_t>(to_look_[n])] = sampled_[n];
  }
}

void Edge::FindSolids(const Probe& probe, double reach_mm, double stiffness_N_per_mm, StepProblem& problem) {
  SampleSolids(probe, [this](std::size_t i) { return points_[i].touching != Touching::kMoving; });
  AddSolids(probe, reach_mm, stiffness_N_per_mm, problem);
}

void Edge::FindSolidsWhileCutting(const Probe& probe, double reach_mm, double stiffness_N_per_mm,
                                  StepProblem& problem) {
  SampleSolids(probe, [&](std::size_t i) {
    if (i < tooth_points_) return has_metal_;
    if (points_[i].touching == Touching::kMoving) return true;  // has no bound: see held_
    return points_[i].touching != Touching::kStopped && CalcBound(i) <= reach_mm;
  });
  for (const int looked_at : to_look_) {
    const auto i = static_cast<std::size_t>(looked_at);
    if (i >= tooth_points_) {
      distance_[i] = solid_distance_[i];
      looked_at_mm_[i] = travelled_mm_;
    } else if (solid_distance_[i] <= reach_mm && !IsAtMetal(probe, points_[i])) {
      solid_distance_[i] = kNotInContact;
    }
  }
  AddSolids(probe, reach_mm, stiffness_N_per_mm, problem);
}

/// Returns whether there is metal at a point or less than a voxel in front of it. Where metal ends, phi and the regions
/// disagree by up to a voxel.
bool Edge::IsAtMetal(const Probe& probe, const Point& point) const {
  for (const double ahead_vox : {kMaterialAheadVoxels, 0.5, 1.0}) {
    const Vec3 p_T = point.p_T + ahead_vox * field_.voxel_mm() * point.e_T;
    if (field_.is_metal(field_.RegionAt(probe.World(p_T)))) return true;
  }
  return false;
}

/// Fills problem.solids with the points whose solid_distance_ is at most reach_mm.
void Edge::AddSolids(const Probe& probe, double reach_mm, double stiffness_N_per_mm, StepProblem& problem) {
  problem.solids.clear();
  found_.clear();
  for (std::size_t i = 0; i < points_.size(); i += static_cast<std::size_t>(stride_)) {
    const Point& point = points_[i];
    const double distance = solid_distance_[i];
    if (distance > reach_mm) {
      penetration_.set_known_mm(static_cast<int>(i), 0);
      continue;
    }
    Vec3 away = probe.Away(point.p_T);
    // Contact with a rim acts across it. Otherwise the points of a rim would catch one by one on a sharp edge of bone,
    // because each finds the side of the edge that it has just passed.
    if (is_joined()) {
      const Vec3 along(-point.e_T.y, point.e_T.x, 0);
      away -= glm::dot(away, along) * along;
    }
    const double length = glm::length(away);
    // Deep in the bone the gradient vanishes: use the outward direction of the edge instead.
    const Vec3 into = length > 0.1 ? -away / length : point.e_T;
    problem.solids.push_back({MakeRow(Turn(into), Turn(point.p_T - p_EC_)), -distance, stiffness_N_per_mm * stride_});
    found_.push_back({static_cast<int>(i), -distance});
  }
}

double Edge::SetDepths(StepProblem& problem, bool may_rise) {
  double energy = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    SolidPoint& solid = problem.solids[n];
    solid.depth_mm = penetration_.Limit(found_[n].point, found_[n].depth_mm, problem.tau_s, may_rise);
    const double depth = std::max(solid.depth_mm, 0.0);
    energy += 0.5 * solid.stiffness_N_per_mm * depth * depth;
  }
  return energy;
}

double Edge::Remember(const StepProblem& problem, const Twist& u, double fraction) {
  double energy = 0;
  for (std::size_t n = 0; n < found_.size(); ++n) {
    const SolidPoint& solid = problem.solids[n];
    const double motion_mm = problem.tau_s * Dot(solid.row, u);
    const double depth = std::max(solid.depth_mm + fraction * motion_mm, 0.0);
    penetration_.set_known_mm(found_[n].point, depth);
    energy += 0.5 * solid.stiffness_N_per_mm * depth * depth;
  }
  return energy;
}

void Edge::Release() {
  penetration_.Forget();
}

void Edge::Forget() {
  Release();
  travelled_mm_ = 0;
  std::fill(looked_at_mm_.begin(), looked_at_mm_.end(), -1e9);
}

}  // namespace kerf
