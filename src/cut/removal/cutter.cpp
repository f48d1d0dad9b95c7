#include "cut/removal/cutter.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "bone/grid/piece_removal.h"
#include "cut/removal/edge_leaves.h"
#include "cut/removal/ledger.h"
#include "cut/removal/metal_voxels.h"
#include "cut/removal/near_bricks.h"
#include "cut/removal/sweep.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kAll = std::numeric_limits<double>::infinity();
// For a kerf as wide as a voxel, phi interpolated at its middle is at least 0 at any position and orientation: the
// weighted mean distance of a cell's corners from a plane through the point is at most half a voxel. The excess over
// 1 allows for rounding.
constexpr double kMinKerfVoxels = 1.005;

/// Returns the zone in which the tool cuts.
EdgeZone MakeZone(const Tool& tool, const BoneField& field, CutWith with) {
  EdgeZone zone;
  zone.band_mm = zone.outside_mm = field.band_mm();
  zone.depth_mm = kAll;
  zone.kind = tool.index();
  zone.form = GetForm(tool);
  zone.radius_mm = CalcRadius(tool);
  zone.solid = CalcRoundSolid(tool);
  if (zone.solid) {
    zone.half_thickness_mm = zone.centre_z_mm = 0.5 * zone.solid->top_z_mm;
    zone.outside_mm *= zone.solid->CalcCornerFactor();
    if (with == CutWith::kEdge && !zone.solid->side_cuts) {
      zone.ceiling_mm = zone.solid->corner_z_mm + CalcToothSide(zone.radius_mm, field.voxel_mm()) - zone.centre_z_mm;
    }
  } else if (zone.is_blade()) {
    zone.half_thickness_mm = 0.5 * CalcKerfWidth(CalcCutWidth(tool), field.voxel_mm());
    zone.blade = FindPlanarBlade(tool);
    if (zone.blade) {
      zone.outline = zone.blade->SweepOutline({});
      zone.radius_mm = CalcReach(tool);
    }
    if (with == CutWith::kEdge) zone.depth_mm = CalcToothSide(zone.radius_mm, field.voxel_mm());
  }
  return zone;
}

/// Returns the part of the zone that a step of a ball, or of a blade in its plane, can change. Further inside, the
/// flats are nearer than the rim, or there is only air. The ends of a solid of revolution change all of it.
EdgeZone MakeEdgeZone(const EdgeZone& zone, double voxel_mm, double stroke_mm) {
  EdgeZone edge = zone;
  if (!zone.outline.empty()) {
    // The edge may be anywhere in its stroke.
    edge.outline = zone.blade->SweepOutline({-0.5 * stroke_mm, 0.5 * stroke_mm});
    edge.depth_mm += stroke_mm;
    return edge;
  }
  const double depth_mm = zone.is_blade() ? zone.half_thickness_mm + 0.5 * voxel_mm : zone.band_mm;
  if (zone.depth_mm == kAll && !zone.solid) edge.depth_mm = depth_mm;
  return edge;
}

}  // namespace

struct Cutter::State {
  State(BoneField& the_field, const Tool& tool, CutWith with, bool the_whole_voxels, int the_precision_bits)
      : field(the_field),
        h(field.voxel_mm()),
        zone(MakeZone(tool, field, with)),
        whole_voxels(the_whole_voxels),
        precision_bits(the_precision_bits),
        leaves(field, MakeEdgeZone(zone, h, CalcStroke(tool))),
        bricks(h, field.lowest(), NearBricks::Keeps(zone) ? leaves.capacity() : 1),
        max_piece_mm(0.25 * leaves.slack_mm()),
        ledger(field),
        metal(field) {
    // The sweep of an edge of a solid of revolution is exact up to length^2 / (8 radius), with a radius of at least a
    // quarter of the edge's where it matters.
    if (zone.solid) {
      max_piece_mm = std::min(max_piece_mm, std::sqrt(2 * zone.solid->corner_radius_mm * kFlankTolerance * h));
    }
  }

  void CutPiece(const EdgeZone& cuts, const Pose& X_from, const Pose& X_to, const SlideRange& slide, bool new_only,
                double flank_slack_mm, Result& result);
  bool MakeRoom(const LeafIndex& leaf);
  template <bool kHasMetal>
  void CutLeaf(const Sweep& sweep, const LeafIndex& leaf, Result& result);
  void KeepMetal(const MetalVoxels::Leaf& in_metal, const PhiParts& old, float* now, CarveLoss& loss) const;
  bool FlanksMoved(const Pose& X) const;
  double CalcFlankSlack(const Pose& X_a, const Pose& X_b) const;
  void CountInMm3(Result& result) const { result.removed_mm3 *= h * h * h; }

  BoneField& field;
  double h;
  EdgeZone zone;
  bool whole_voxels;
  int precision_bits;
  EdgeLeaves leaves;
  NearBricks bricks;
  double max_piece_mm;  // longest part of a step
  Ledger ledger;
  MetalVoxels metal;
  std::optional<Pose> X_last;  // end of the last cut, if it was complete
  SlideRange last_slide;
  std::optional<Pose> X_flanks;  // pose of the last visit of the whole cutting zone
  Effort effort;
  std::array<float, BoneField::kLeafVoxels> values;
};

double CalcKerfWidth(double thickness_mm, double voxel_mm) {
  return std::max(thickness_mm, kMinKerfVoxels * voxel_mm);
}

Cutter::Cutter(BoneField& field, const Tool& tool, CutWith with, bool whole_voxels, int precision_bits)
    : state_(std::make_unique<State>(field, tool, with, whole_voxels, precision_bits)) {}
Cutter::~Cutter() = default;
Cutter::Cutter(Cutter&&) noexcept = default;
Cutter& Cutter::operator=(Cutter&&) noexcept = default;

bool Cutter::Replace(const LeafIndex& leaf, const float* from, const float* to) {
  State& s = *state_;
  const LeafIndex low = s.field.lowest(), high = s.field.highest();
  if (leaf.x < low.x || leaf.y < low.y || leaf.z < low.z || leaf.x > high.x || leaf.y > high.y || leaf.z > high.z) {
    return false;
  }
  if (!s.MakeRoom(leaf)) return false;
  const BoneField::CutValues now = s.field.Open(leaf);
  if (now.cut == nullptr) return false;
  for (int i = 0; i < BoneField::kLeafVoxels; ++i) now.cut[i] = ReplaceValue(now.cut[i], from[i], to[i]);
  BoneField::SetPhi(now);
  return true;
}

bool Cutter::Swap(const LeafIndex& leaf, float* values) {
  State& s = *state_;
  return s.MakeRoom(leaf) && s.field.Swap(leaf, values);
}

void Cutter::AddNeed(const LeafIndex& leaf, Need& need) const {
  const State& s = *state_;
  const LeafIndex low = s.field.lowest(), high = s.field.highest();
  if (leaf.x < low.x || leaf.y < low.y || leaf.z < low.z || leaf.x > high.x || leaf.y > high.y || leaf.z > high.z) {
    need.outside = true;
    return;
  }
  need.spare_leaves += s.field.CountNeededSpares(leaf);
}

bool Cutter::HasRoomFor(const Need& need) const {
  return !need.outside && need.spare_leaves <= state_->field.spare_leaves();
}

void Cutter::BoneRestored() {
  Lift();
  state_->leaves.Forget();
}

void Cutter::Lift() {
  state_->X_last.reset();
}
const std::array<double, 256>& Cutter::CalcRemovedByRegion() {
  return state_->ledger.Account();
}
std::size_t Cutter::CalcMemoryBytes() const {
  return sizeof(State) + state_->leaves.CalcMemoryBytes() + state_->bricks.CalcMemoryBytes() +
         state_->ledger.CalcMemoryBytes() + state_->metal.CalcMemoryBytes();
}
const Cutter::Effort& Cutter::effort() const {
  return state_->effort;
}

/// Returns true if any point of the flats has moved along the spindle by more than the tolerance.
bool Cutter::State::FlanksMoved(const Pose& X) const {
  if (!zone.is_blade()) return false;
  const Vec3 normal = X.Vector({0, 0, 1});
  const double along = std::abs(glm::dot(normal, X.p_AB - X_flanks->p_AB));
  const double tilt = glm::length(glm::cross(normal, X_flanks->Vector({0, 0, 1})));
  return along + tilt * zone.radius_mm > kBladeTolerance * h;
}

/// Returns a bound on how far the tool's sides are from where they last cut, apart from the motion of the sweep.
double Cutter::State::CalcFlankSlack(const Pose& X_a, const Pose& X_b) const {
  if (!zone.solid) return kBladeTolerance * h;
  return glm::length(X_a.Vector({0, 0, 1}) - X_b.Vector({0, 0, 1})) * (zone.CalcReach() + zone.outside_mm);
}

Cutter::Result Cutter::Cut(const Pose& X_from, const Pose& X_to, const SlideRange& slide) {
  State& s = *state_;
  s.effort = {};
  Result result;
  Pose X_a = s.zone.Centre(X_from);
  Pose X_b = s.zone.Centre(X_to);
  if (s.zone.form == ToolForm::kBall) X_a.R_AB = X_b.R_AB = Quat(1, 0, 0, 0);  // a ball's rotation has no effect
  // A cut that continues the last one visits only the newly swept part.
  const bool goes_on = s.X_last && s.X_last->p_AB == X_a.p_AB && s.X_last->R_AB == X_a.R_AB &&
                       slide.least_mm <= s.last_slide.most_mm && slide.most_mm >= s.last_slide.least_mm;
  const bool new_only = goes_on && !s.FlanksMoved(X_b);
  if (!goes_on) s.bricks.Forget();
  const double distance_mm = glm::length(X_b.p_AB - X_a.p_AB);
  if (!new_only || distance_mm > 0 || (s.zone.solid && s.CalcFlankSlack(X_a, X_b) > 0) || !s.zone.outline.empty()) {
    // A caller that uses CountSubsteps() gets one piece, but for a thin bur on coarse voxels.
    const double pieces = std::max(1.0, std::ceil(distance_mm / s.max_piece_mm));
    for (double i = 1; i <= pieces; ++i) {
      Pose X = X_b;
      if (i < pieces) X.p_AB = X_a.p_AB + (X_b.p_AB - X_a.p_AB) * (1 / (pieces - i + 1));
      s.CutPiece(s.zone, X_a, X, slide, new_only && (i == 1 || s.zone.solid), s.CalcFlankSlack(X_a, X), result);
      X_a = X;
    }
  }
  if (!new_only) s.X_flanks = X_b;
  s.X_last = X_b;
  s.last_slide = slide;
  if (result.out_of_leaves) Lift();
  s.CountInMm3(result);
  return result;
}

Cutter::Result Cutter::CutAround(const Pose& X, const SlideRange& slide) {
  State& s = *state_;
  s.effort = {};
  Result result;
  EdgeZone whole = s.zone;
  whole.depth_mm = kAll;
  whole.ceiling_mm = EdgeZone{}.ceiling_mm;
  const Pose X_Z = whole.Centre(X);
  s.CutPiece(whole, X_Z, X_Z, slide, false, 0, result);
  Lift();
  s.CountInMm3(result);
  return result;
}

void Cutter::State::CutPiece(const EdgeZone& cuts, const Pose& X_from, const Pose& X_to, const SlideRange& slide,
                             bool new_only, double flank_slack_mm, Result& result) {
  const Sweep sweep(cuts, X_from, X_to, slide, h, flank_slack_mm, new_only, whole_voxels, precision_bits);
  effort.is_new_list |=
      leaves.Update(X_to, cuts.outline.empty() ? sweep.length_mm : glm::length(X_to.p_AB - X_from.p_AB),
                    !new_only && cuts.depth_mm == kAll);
  bricks.Begin(sweep, X_from, &cuts == &zone);
  LeafList& list = leaves.list();
  effort.listed_leaves += static_cast<int>(list.size());
  const LeafCull cull = sweep.MakeCull(list.origin_W());
  if (field.has_metal()) {
    list.ForEachNear(cull, [&](const LeafIndex& leaf) { CutLeaf<true>(sweep, leaf, result); });
  } else {
    list.ForEachNear(cull, [&](const LeafIndex& leaf) { CutLeaf<false>(sweep, leaf, result); });
  }
  effort.searched_leaves += bricks.searched();
}

/// Records the leaf's values before its first change. Returns false and changes nothing if there are too few spare
/// leaves for the change.
bool Cutter::State::MakeRoom(const LeafIndex& leaf) {
  if (field.spare_leaves() < field.CountNeededSpares(leaf)) return false;
  if (!ledger.IsNoted(leaf)) ledger.Note(leaf);
  return true;
}

/// Restores the values in metal, and counts what is lost without them.
void Cutter::State::KeepMetal(const MetalVoxels::Leaf& in_metal, const PhiParts& old, float* now,
                              CarveLoss& loss) const {
  loss.voxels = loss.changed = 0;
  const auto occupancy = [this](float phi) { return std::clamp(0.5 - static_cast<double>(phi) / h, 0.0, 1.0); };
  for (std::size_t i = 0; i < in_metal.size(); ++i) {
    if (in_metal[i]) now[i] = old.cut[i];
    if (now[i] == old.cut[i]) continue;
    ++loss.changed;
    loss.voxels += occupancy(std::max(old.whole[i], old.cut[i])) - occupancy(std::max(old.whole[i], now[i]));
  }
}

template <bool kHasMetal>
void Cutter::State::CutLeaf(const Sweep& sweep, const LeafIndex& leaf, Result& result) {
  if (field.kind(leaf) == BoneField::LeafKind::kOutside) return;
  const Vec3 p_T = sweep.grid.Corner(leaf);
  const std::array<float, 3> corner_T = {static_cast<float>(p_T.x), static_cast<float>(p_T.y),
                                         static_cast<float>(p_T.z)};
  ++effort.leaves;
  const std::uint64_t near = bricks.Find(leaf, corner_T);
  if (near == 0) return;
  const MetalVoxels::Leaf* const in_metal = kHasMetal ? metal.Find(leaf) : nullptr;
  const BoneField::CutValues own = field.Find(leaf);
  const bool in_place =
      own.cut != nullptr && ledger.IsNoted(leaf) && in_metal == nullptr && !field.NeedsOldValues(leaf);
  CarveLoss loss;
  if (in_place) {
    loss = CarveLeaf(sweep.step, corner_T, near, {own.cut, own.whole, own.phi});
    if (loss.changed > 0) field.Write(leaf);
  } else {
    // Carve a copy, so that the old values can be recorded if any value changes.
    const PhiParts old = field.ReadParts(leaf);
    std::copy_n(old.cut, BoneField::kLeafVoxels, values.begin());
    const float* const whole = old.whole == field.inside() ? nullptr : old.whole;
    loss = CarveLeaf(sweep.step, corner_T, near, {values.data(), whole, nullptr});
    if (in_metal != nullptr && loss.changed > 0) KeepMetal(*in_metal, old, values.data(), loss);
    if (loss.changed > 0) {
      if (!MakeRoom(leaf)) {
        result.out_of_leaves = true;
        return;
      }
      const BoneField::CutValues now = field.Write(leaf);
      std::copy(values.begin(), values.end(), now.cut);
      BoneField::SetPhi(now);
    }
  }
  effort.bricks += std::popcount(near);
  effort.changed_voxels += loss.changed;
  if (loss.changed > 0) result.removed_mm3 += loss.voxels;
}

}  // namespace kerf
