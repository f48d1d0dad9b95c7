#include "session/marks/structures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <tuple>

#include "bone/grid/removed.h"
#include "session/marks/mark_tube.h"
#include "session/marks/region_parts.h"
#include "session/marks/removed_sum.h"
#include "session/marks/structure_body.h"

namespace kerf {
namespace {

constexpr double kRootReach_mm = 1.5;
constexpr double kCluster_mm = 2;

/// Points in groups of neighbours, to find the nearest pair of two clouds without comparing all.
class PointCloud {
 public:
  void Add(const Vec3& p) {
    const auto cell = [](double x) { return static_cast<int>(std::floor(x / kCluster_mm)); };
    Cluster& cluster = clusters_[{cell(p.x), cell(p.y), cell(p.z)}];
    cluster.points.push_back(p);
    cluster.box.Include(p);
  }
  bool empty() const { return clusters_.empty(); }

  struct Pair {
    double distance_mm = std::numeric_limits<double>::infinity();
    Vec3 p{0};  // of this cloud
    Vec3 q{0};  // of the other
  };
  Pair FindNearest(const PointCloud& other) const {
    std::vector<std::tuple<double, const Cluster*, const Cluster*>> order;
    for (const auto& [a_cell, a] : clusters_) {
      for (const auto& [b_cell, b] : other.clusters_) {
        const Vec3 gap = glm::max(glm::max(a.box.lower - b.box.upper, b.box.lower - a.box.upper), Vec3(0));
        order.emplace_back(glm::length(gap), &a, &b);
      }
    }
    std::sort(order.begin(), order.end(),
              [](const auto& a, const auto& b) { return std::get<double>(a) < std::get<double>(b); });
    Pair best;
    for (const auto& [least_mm, a, b] : order) {
      if (least_mm >= best.distance_mm) break;
      for (const Vec3& p : a->points) {
        for (const Vec3& q : b->points) {
          const double distance_mm = glm::length(p - q);
          if (distance_mm < best.distance_mm) best = {.distance_mm = distance_mm, .p = p, .q = q};
        }
      }
    }
    return best;
  }

 private:
  struct Cluster {
    std::vector<Vec3> points;
    Box3 box;
  };
  std::map<std::tuple<int, int, int>, Cluster> clusters_;
};

ToothPart CalcToothPart(const Bone& bone, const std::array<bool, 256>& teeth, const Vec3& p_W) {
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3 direction = glm::normalize(Vec3(x, y, z));
        for (double s = bone.region_voxel_mm(); s <= kRootReach_mm; s += bone.region_voxel_mm()) {
          const Vec3 q = p_W + s * direction;
          const int region = bone.SignedDistance(q) < 0 ? bone.RegionAt(q) : 0;
          if (region > 0 && region < 256 && !teeth[static_cast<std::size_t>(region)]) return ToothPart::kRoot;
        }
      }
    }
  }
  return ToothPart::kCrown;
}

void AddRegionStructures(const Bone& before, const Bone& after, const std::vector<RemovedCell>& removed,
                         const PointCloud& cut, Tissue tissue, double mid_x_mm, std::vector<StructureResult>& results) {
  const RegionParts parts(before, tissue, mid_x_mm);
  std::vector<StructureResult> found = parts.structures();
  std::vector<PointCloud> points(found.size());
  for (const RegionParts::Run& run : parts.runs()) {
    for (int z = run.z0; z <= run.z1; ++z) points[static_cast<std::size_t>(run.part)].Add(parts.PointOf(run, z));
  }
  std::vector<RemovedSum> sums(found.size());
  const std::array<bool, 256> regions = FindRegionsOf(before, tissue);
  for (const RemovedCell& cell : removed) {
    if (const int part = FindPartOf(cell, before, parts, regions); part >= 0)
      sums[static_cast<std::size_t>(part)].Add(cell);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    StructureResult& result = found[i];
    if (!(result.size_mm3 > 0)) continue;
    sums[i].Fill(before.voxel_mm(), result);
    if (result.is_cut) {
      result.is_severed = StructureBody(before, parts, static_cast<int>(i)).IsSevered(after);
    } else if (!cut.empty()) {
      const PointCloud::Pair pair = points[i].FindNearest(cut);
      // Between the centres of a voxel and of a removed cell, each of which ends half of its edge before.
      result.distance_mm = std::max(0.0, pair.distance_mm - 0.5 * (parts.voxel_mm() + before.voxel_mm()));
      result.p_W = pair.p;
    }
    if (tissue == Tissue::kTooth && result.distance_mm) {
      result.part = CalcToothPart(before, regions, result.p_W);
    }
    results.push_back(result);
  }
}

StructureResult AssessMark(const Mark& mark, const Bone& before, const Bone& after,
                           const std::vector<RemovedCell>& removed, double mid_x_mm) {
  const MarkTube tube(mark);
  StructureResult result = DescribeMark(mark, tube, mid_x_mm);
  RemovedSum sum;
  for (const RemovedCell& cell : removed) {
    if (!(cell.mm3 > 0)) continue;
    const MarkTube::Nearest nearest = tube.Find(cell.p_W);
    if (nearest.distance_mm <= 0) sum.Add(cell.mm3, nearest.p_W);
    const double distance_mm = std::max(0.0, nearest.distance_mm - 0.5 * before.voxel_mm());
    if (result.distance_mm && distance_mm >= *result.distance_mm) continue;
    result.distance_mm = distance_mm;
    result.p_W = nearest.p_W;
  }
  sum.Fill(before.voxel_mm(), result);
  if (result.is_cut) result.is_severed = StructureBody(before, tube).IsSevered(after);
  return result;
}

/// Returns the name of a tooth or row without a number of its own.
Message NameTooth(const StructureResult& tooth) {
  const bool left = tooth.side == BodySide::kLeft;
  if (tooth.side == BodySide::kBoth) return {MarkMessage("row of touching teeth, on both sides"), {}};
  if (tooth.is_row) {
    return {left ? MarkMessage("row of touching teeth, patient's left")
                 : MarkMessage("row of touching teeth, patient's right"),
            {}};
  }
  if (tooth.number == 0) {
    return {
        left ? MarkMessage("tooth behind a row, patient's left") : MarkMessage("tooth behind a row, patient's right"),
        {}};
  }
  return {left ? MarkMessage("tooth {} from the middle, patient's left")
               : MarkMessage("tooth {} from the middle, patient's right"),
          {Quantity{static_cast<double>(tooth.number), 0}}};
}

}  // namespace

StructureResult DescribeMark(const Mark& mark, const MarkTube& tube, double mid_x_mm) {
  double length_mm = 0;
  double left_mm = 0;
  for (std::size_t i = 1; i < tube.curve_W().size(); ++i) {
    const Vec3& a = tube.curve_W()[i - 1];
    const Vec3& b = tube.curve_W()[i];
    const double step_mm = glm::length(b - a);
    length_mm += step_mm;
    // The part of the segment with x above the middle.
    const double low = std::min(a.x, b.x);
    const double high = std::max(a.x, b.x);
    left_mm += step_mm * (high > low ? std::clamp((high - mid_x_mm) / (high - low), 0.0, 1.0) : a.x > mid_x_mm ? 1 : 0);
  }
  const double r = mark.radius_mm;
  return {.name = mark.name,
          .kind = mark.kind,
          .side = length_mm > 0                         ? CalcSide(length_mm, left_mm)
                  : tube.curve_W().front().x > mid_x_mm ? BodySide::kLeft
                                                        : BodySide::kRight,
          .is_mark = true,
          .size_mm3 = std::numbers::pi * r * r * (length_mm + 4.0 / 3.0 * r)};
}

StructureAssessment AssessStructures(const Bone& before, const Bone& after, const std::vector<Mark>& marks,
                                     std::optional<double> mid_x_mm) {
  CheckMarks(marks);
  const std::vector<RemovedCell> removed = FindRemoved(before, after);
  const double mid = mid_x_mm.value_or(before.empty() ? 0.0 : before.CalcBounds().centre().x);
  PointCloud cut;
  for (const RemovedCell& cell : removed) {
    if (cell.mm3 > 0) cut.Add(cell.p_W);
  }
  StructureAssessment out;
  AddRegionStructures(before, after, removed, cut, Tissue::kCanal, mid, out.structures);
  out.canal_known = !out.structures.empty();
  const std::size_t canals = out.structures.size();
  AddRegionStructures(before, after, removed, cut, Tissue::kTooth, mid, out.structures);
  out.teeth_known = out.structures.size() > canals;
  AddRegionStructures(before, after, removed, cut, Tissue::kLesion, mid, out.structures);
  for (const Mark& mark : marks) {
    if (mark.points_W.empty()) continue;
    out.structures.push_back(AssessMark(mark, before, after, removed, mid));
    out.canal_known |= IsNerve(mark.kind);
    out.teeth_known |= IsTooth(mark.kind);
  }
  std::stable_sort(out.structures.begin(), out.structures.end(),
                   [](const StructureResult& a, const StructureResult& b) {
                     if (a.is_cut != b.is_cut) return a.is_cut;
                     return a.distance_mm.value_or(0) < b.distance_mm.value_or(0);
                   });
  return out;
}

Message NameStructure(const StructureResult& structure) {
  if (!structure.name.empty()) return {"{}", {structure.name}};
  if (structure.kind == MarkKind::kLesion) return {MarkMessage("lesion"), {}};
  if (structure.fdi != 0) return {MarkMessage("tooth {}"), {Quantity{static_cast<double>(structure.fdi), 0}}};
  if (structure.kind == MarkKind::kTooth) return NameTooth(structure);
  switch (structure.side) {
    case BodySide::kLeft:
      return {MarkMessage("canal of the nerve, patient's left"), {}};
    case BodySide::kRight:
      return {MarkMessage("canal of the nerve, patient's right"), {}};
    case BodySide::kBoth:
      break;
  }
  return {MarkMessage("canal of the nerve, on both sides"), {}};
}

Message DescribePlaceAlong(int axis, double at_mm) {
  static constexpr std::array<std::array<const char*, 2>, 3> kSides{{{MarkMessage("left"), MarkMessage("right")},
                                                                     {MarkMessage("back"), MarkMessage("front")},
                                                                     {MarkMessage("up"), MarkMessage("down")}}};
  const auto& sides = kSides.at(static_cast<std::size_t>(axis));
  return {"{} {}", {Quantity{std::abs(at_mm), 1, "mm"}, std::string(sides[at_mm < 0 ? 1 : 0])}};
}

Message DescribePlace(const Vec3& p_W) {
  Message place{"{} {}, {} {}, {} {}", {}};
  for (int axis = 0; axis < 3; ++axis) {
    for (auto& part : DescribePlaceAlong(axis, p_W[axis]).values) place.values.push_back(std::move(part));
  }
  return place;
}

const char* ExplainPlaces() {
  return MarkMessage(
      "Places are distances towards the patient's left or right, front or back, and up or down, from the origin "
      "of the coordinates of the CT, which the scanner has set; without a CT, from that of the bone's model or "
      "file.");
}

}  // namespace kerf
