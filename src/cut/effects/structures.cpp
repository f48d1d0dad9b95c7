// structures: the nerve canal and the roots of teeth, given as regions of the bone, a surface, or tubes along curves.
// The effect computes the distance of the tool from them, and the volume cut from them.
//
//   Every structure is converted to voxels of the bone's region grid. The distance is measured from the tool (of a
//   blade with a stroke: from all that it passes in a whole stroke) to the nearest of these voxels. It is computed
//   again when the tool may have come nearer by a hundredth of the distance, or by 0.01 mm. In between it is reduced by
//   the tool's motion, so that motion never makes it an overestimate. A search has a bounded number of queries; near a
//   structure it is spread over several ticks.
//
// A breach occurs when a tooth cuts such a voxel. Its volume is the volume that a tick removes, times the fraction of
// the cut that is due to such teeth, weighted by their number and feed. Its depth is the distance of such a tooth from
// the nearest voxel of other bone. Its force is the thrust of such teeth.
#include "cut/effects/structures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kLookAgain = 0.01;          // motion of the tool that triggers a new search, relative to the distance
constexpr double kLookAgain_mm = 0.01;       // the same near a structure
constexpr std::size_t kMaxQueries = 48;      // Embree queries in a search
constexpr std::size_t kFirstQueries = 2000;  // in the first search
constexpr std::size_t kDepthsPerStep = 8;    // teeth in breach whose depth is computed in a step
constexpr double kDepthGrows_mm = 0.1;       // growth of the depth per query, which limits the range of the search
constexpr const char* kNone = "none";
constexpr double kHysteresis = 1.1;  // the tool counts as away again beyond this multiple of the margin

/// Throws Error if the content of a file is too far from the bone or too fine for its voxels.
void AddFile(const EffectFile& file, double radius_mm, const Bone& bone, StructureVoxels& all) {
  const double h = bone.region_voxel_mm();
  Box3 bounds_W;
  for (const Vec3& p : file.mesh.points) bounds_W.Include(p);
  for (const EffectFile::Curve& curve : file.curves) {
    for (const Vec3& p : curve.points) bounds_W.Include(p);
  }
  if (!file.curves.empty()) bounds_W = bounds_W.Grown(radius_mm);
  const Box3 of_bone = bone.CalcBounds();
  const Vec3 gap = glm::max(glm::max(bounds_W.lower - of_bone.upper, of_bone.lower - bounds_W.upper), Vec3(0));
  const auto refuse = [&](const std::string& what) { throw Error(file.place + file.name + ": " + what); };
  if (glm::length(gap) > StructuresEffect::kLook_mm) {
    refuse(
        fmt::format("lies {:.0f} mm away from the bone, more than the limit of {:g} mm; it must be in mm, in the "
                    "bone's own frame (for a CT: LPS)",
                    glm::length(gap), StructuresEffect::kLook_mm));
  }
  if (!file.curves.empty() && radius_mm < h) {
    refuse(fmt::format("radius_mm = {:g} is less than a voxel of the bone's regions, {:g} mm", radius_mm, h));
  }
  if (!IsInWorld(bounds_W.lower) || !IsInWorld(bounds_W.upper)) refuse("extends beyond 1 km; it must be in mm");
  StructureVoxels voxels(h);
  try {
    voxels.AddSurface(file.mesh);
    for (const EffectFile::Curve& curve : file.curves) voxels.AddCurve(curve, radius_mm);
  } catch (const Error& e) {
    refuse(e.what());
  }
  if (voxels.empty()) refuse(fmt::format("is too small for the bone's regions, whose voxels are {:g} mm wide", h));
  all.Add(voxels);
}

StructureVoxels FindVoxels(const StructuresParams& params, const Bone& bone) {
  StructureVoxels all(bone.region_voxel_mm());
  all.AddRegions(bone, params.regions);
  if (params.surface_file != nullptr) AddFile(*params.surface_file, 0, bone, all);
  if (params.markups_file != nullptr) AddFile(*params.markups_file, params.radius_mm, bone, all);
  all.Finish();
  return all;
}

std::string FindFault(std::span<const EffectValue> values) {
  const auto params = ReadEffectParameters<StructuresParams>(values);
  if (params.tissues == kNone && params.surface.empty() && params.markups.empty()) {
    return "tissues is \"none\", and neither surface nor markups is set";
  }
  if (!params.markups.empty() && !(params.radius_mm > 0)) {
    return "markups needs radius_mm, the radius of its curves and points";
  }
  if (params.markups.empty() && params.radius_mm > 0) return "radius_mm is not used without markups; remove it";
  return "";
}

std::vector<Box3> Moved(std::vector<Box3> boxes, const Vec3& offset) {
  for (Box3& box : boxes) box = {box.lower + offset, box.upper + offset};
  return boxes;
}

}  // namespace

StructuresEffect::StructuresEffect(const StructuresParams& params, const EffectSetup& setup)
    : regions_(params.regions),
      warn_mm_(params.warn_mm),
      p_WF_mm_(setup.p_WF_mm),
      voxels_(FindVoxels(params, setup.bone)),
      from_files_(params.surface_file != nullptr || params.markups_file != nullptr),
      ahead_mm_(kMaterialAheadVoxels * setup.field.voxel_mm()),
      distance_(Moved(voxels_.MakeBoxes(), -setup.p_WF_mm), setup.tool),
      shell_(Moved(voxels_.MakeShell(), -setup.p_WF_mm)),
      reach_mm_(setup.shape.reach_mm) {
  events_.reserve(kMaxEvents);
}

void StructuresEffect::Solved(const EffectSolved& solved) {
  double in_N = 0;
  std::size_t in_breach = 0, searches = 0;
  const std::size_t stride = std::max<std::size_t>(1, solved.teeth.size() / kDepthsPerStep);
  for (const ToothLoad& tooth : solved.teeth) {
    const double cut = solved.time_s * tooth.teeth * tooth.speed_mm_per_s;
    cut_all_ += cut;
    if (!(cut > 0)) continue;
    if (!regions_[static_cast<std::size_t>(tooth.region)] &&
        !(from_files_ && voxels_.Contains(solved.X_FT.Point(tooth.p_T + ahead_mm_ * tooth.e_T) + p_WF_mm_))) {
      continue;
    }
    cut_fraction_ += cut;
    in_N += tooth.thrust_N;
    // Only a few teeth are searched in each step, in turn. The range of the search is limited to the known depth and a
    // little more, so the depth approaches its true value over several steps.
    if (in_breach++ % stride != next_tooth_ % stride || searches == kDepthsPerStep) continue;
    ++searches;
    const double limit_mm = breach_depth_mm_ + kDepthGrows_mm;
    breach_depth_mm_ =
        std::max(breach_depth_mm_, shell_.FindNearest(solved.X_FT.Point(tooth.p_T), limit_mm).distance_mm);
  }
  ++next_tooth_;
  force_now_N_ = std::max(force_now_N_, in_N);
}

void StructuresEffect::End(EffectEnd& end) {
  time_s_ += end.dt_s;
  const double moved_mm = looked_ ? CalcTravel(X_looked_, end.X_FT, reach_mm_) : 0;
  if (!looked_ || moved_mm > std::max(kLookAgain_mm, kLookAgain * looked_mm_)) {
    const StructureDistance::Nearest nearest =
        distance_.Find(end.X_FT, kLook_mm, looked_ ? kMaxQueries : kFirstQueries);
    looked_mm_ = distance_mm_ = nearest.distance_mm;
    found_ = nearest.distance_mm < kLook_mm;
    p_F_mm_ = nearest.p_F;
    X_looked_ = end.X_FT;
    looked_ = true;
  } else if (found_) {
    distance_mm_ = std::max(0.0, looked_mm_ - moved_mm);
  }
  const bool breach = cut_fraction_ > 0;
  if (breach) {
    breach_mm3_ += end.removed_mm3 * cut_fraction_ / cut_all_;
    breach_force_N_ = std::max(breach_force_N_, force_now_N_);
  }
  cut_fraction_ = cut_all_ = force_now_N_ = 0;
  if (breach && !in_breach_) RecordEvent(StructureEvent::Kind::kBreach);
  in_breach_ = breach;
  if (!near_ && found_ && distance_mm_ < warn_mm_) {
    near_ = true;
    RecordEvent(StructureEvent::Kind::kNear);
  } else if (near_ && (!found_ || distance_mm_ > kHysteresis * warn_mm_)) {
    near_ = false;
    RecordEvent(StructureEvent::Kind::kAway);
  }
}

void StructuresEffect::RecordEvent(StructureEvent::Kind kind) {
  if (events_.size() < kMaxEvents) events_.push_back({kind, time_s_, distance_mm_, p_F_mm_ + p_WF_mm_});
}

void StructuresEffect::Report(std::span<double> channels) const {
  channels[0] = distance_mm_;
  channels[1] = near_ ? 1 : 0;
  channels[2] = breach_mm3_;
  channels[3] = breach_depth_mm_;
  channels[4] = breach_force_N_;
}

std::size_t StructuresEffect::CalcMemoryBytes() const {
  return sizeof(*this) + voxels_.CalcMemoryBytes() + distance_.CalcMemoryBytes() + shell_.CalcMemoryBytes() +
         events_.capacity() * sizeof(StructureEvent);
}

const EffectInfo& Structures() {
  static const EffectInfo kEffect{
      .name = "structures",
      .summary =
          "nerve canal, tooth roots, surfaces and curves: distance from the tool, a warning, and the volume cut from "
          "them",
      .source =
          "the bone's own regions, a surface or markups; the margin of 2 mm follows the anatomical literature (EJOMR "
          "2022: at risk below 2 mm)",
      .reads = "the tool's pose, regions that teeth cut, removed volume",
      .writes = "distance, warning, breach: volume, depth, force; events",
      .state = "the structures' voxels and a hierarchy of their boxes; up to 256 events",
      .sleeps = "until the tool has moved by a hundredth of its distance",
      .hooks = kEffectSolved | kEffectEnd,
      .parameters = ListEffectParameters<StructuresParams>(),
      .channels = {{"distance_mm", "distance of the tool from the nearest voxel of a structure, at most 20"},
                   {"warns", "1 from when the distance falls below warn_mm until it exceeds warn_mm by a tenth"},
                   {"breach_mm3", "volume cut from structures so far, from the fraction of the teeth that cut in one"},
                   {"breach_depth_mm", "largest depth of a tooth below a structure's surface"},
                   {"breach_force_N", "largest thrust of the teeth that cut in a structure"}},
      .find_fault = FindFault,
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        auto params = ReadEffectParameters<StructuresParams>(values);
        bool any = false;
        for (const auto& [id, region] : setup.bone.materials().regions()) {
          if (params.tissues.find(ToString(region.tissue)) == std::string::npos || id < 1 || id > 255) continue;
          params.regions[static_cast<std::size_t>(id)] = any = true;
        }
        if (!any && params.tissues != kNone) {
          throw Error("the bone's table has no region of tissue '" + params.tissues +
                      "', which the effect structures requires");
        }
        const auto file = [&](const char* key) {
          return setup.files.empty() ? nullptr : setup.files[Structures().FindParameter(key)];
        };
        params.surface_file = file("surface");
        params.markups_file = file("markups");
        return std::make_unique<StructuresEffect>(params, setup);
      }};
  return kEffect;
}

}  // namespace kerf
