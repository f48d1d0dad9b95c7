#include "cut/proximity/box_tree.h"

#include <fmt/format.h>
#include <rtcore.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>

#include "kerf/error.h"

namespace kerf {
namespace {

/// Box relative to the middle of all boxes, rounded outwards.
struct FloatBox {
  std::array<float, 3> lower;
  std::array<float, 3> upper;
};

float RoundDown(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float RoundUp(double v) {
  return -RoundDown(-v);
}

Vec3 NearestPoint(const FloatBox& box, const Vec3& p) {
  const auto clamp = [](double v, float lower, float upper) {
    return std::min(std::max(v, static_cast<double>(lower)), static_cast<double>(upper));
  };
  return {clamp(p.x, box.lower[0], box.upper[0]), clamp(p.y, box.lower[1], box.upper[1]),
          clamp(p.z, box.lower[2], box.upper[2])};
}

bool IsBefore(const Vec3& a, const Vec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

struct DistanceQuery {
  const FloatBox* boxes;
  Vec3 p;
  double rounding_mm;  // error bound of Embree's single precision
  double best_mm;
  Vec3 best;
};

bool VisitForDistance(RTCPointQueryFunctionArguments* args) {
  auto& query = *static_cast<DistanceQuery*>(args->userPtr);
  const Vec3 nearest = NearestPoint(query.boxes[args->primID], query.p);
  const double distance = glm::length(nearest - query.p);
  // Of two boxes at the same distance, the choice must not depend on their order in the hierarchy.
  if (distance > query.best_mm || (distance == query.best_mm && !IsBefore(nearest, query.best))) return false;
  query.best_mm = distance;
  query.best = nearest;
  args->query->radius = RoundUp(distance + query.rounding_mm);
  return true;
}

struct PlateQuery {
  const FloatBox* boxes;
  Plate plate;
  double reach_mm;  // largest distance of the plate's points from its centre
  double enough_mm;
  double rounding_mm;
  double best_mm;
};

bool VisitForPlate(RTCPointQueryFunctionArguments* args) {
  auto& query = *static_cast<PlateQuery*>(args->userPtr);
  const Vec3 to_box = NearestPoint(query.boxes[args->primID], query.plate.centre_W) - query.plate.centre_W;
  const double distance = glm::length(to_box);
  double bound = -query.reach_mm;
  if (distance > 0) {
    // The extent of the plate towards the plane in front of the box.
    const double axial = std::min(std::abs(glm::dot(to_box, query.plate.normal_W)) / distance, 1.0);
    const double radial = std::sqrt(1 - axial * axial);
    bound = distance - (query.plate.radius_mm * radial + query.plate.half_thickness_mm * axial);
  }
  if (bound >= query.best_mm) return false;
  query.best_mm = bound;
  // A box further than this from the centre has a larger bound.
  args->query->radius = bound <= query.enough_mm ? 0.0f : RoundUp(bound + query.reach_mm + query.rounding_mm);
  return true;
}

void WriteBounds(const RTCBoundsFunctionArguments* args) {
  const FloatBox& box = static_cast<const FloatBox*>(args->geometryUserPtr)[args->primID];
  *args->bounds_o = {box.lower[0], box.lower[1], box.lower[2], 0, box.upper[0], box.upper[1], box.upper[2], 0};
}

}  // namespace

struct BoxTree::State {
  ~State() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  /// Returns a bound on the sum of two rounding errors: of the point, and of Embree's own sums.
  double CalcRounding(const Vec3& p) const { return 1e-6 * (glm::length(p) + glm::length(0.5 * all.size())) + 1e-6; }

  std::vector<FloatBox> boxes;
  Vec3 middle_W{0};
  Box3 all;  // relative to middle_W
  std::atomic<std::ptrdiff_t> embree_bytes{0};
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

BoxTree::BoxTree(const std::vector<Box3>& boxes) : state_(std::make_unique<State>()) {
  State& s = *state_;
  for (const Box3& box : boxes) {
    s.all.Include(box.lower);
    s.all.Include(box.upper);
  }
  if (boxes.empty()) return;
  s.middle_W = s.all.centre();
  s.all = {s.all.lower - s.middle_W, s.all.upper - s.middle_W};
  s.boxes.reserve(boxes.size());
  for (const Box3& box : boxes) {
    const Vec3 a = box.lower - s.middle_W;
    const Vec3 b = box.upper - s.middle_W;
    s.boxes.push_back({{RoundDown(a.x), RoundDown(a.y), RoundDown(a.z)}, {RoundUp(b.x), RoundUp(b.y), RoundUp(b.z)}});
  }

  // Not "threads=1", which would limit TBB in the whole program to one thread during the device's lifetime. Without the
  // setting, Embree reserves 128 MB for subdivision surfaces, which are all present once memory is locked.
  s.device = rtcNewDevice("tessellation_cache_size=0");
  if (!s.device) {
    throw Error(fmt::format("Embree can't be started (error {}): is the library version 3?",
                            static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  rtcSetDeviceMemoryMonitorFunction(
      s.device,
      [](void* bytes_so_far, ssize_t bytes, bool) {
        static_cast<std::atomic<std::ptrdiff_t>*>(bytes_so_far)->fetch_add(bytes);
        return true;
      },
      &s.embree_bytes);
  s.scene = rtcNewScene(s.device);
  rtcSetSceneFlags(s.scene, RTC_SCENE_FLAG_COMPACT);
  const RTCGeometry geometry = rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(s.boxes.size()));
  rtcSetGeometryUserData(geometry, s.boxes.data());
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* args) { WriteBounds(args); }, nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(s.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(s.scene);
  if (const RTCError error = rtcGetDeviceError(s.device); error != RTC_ERROR_NONE) {
    throw Error(
        fmt::format("Embree can't build a tree of {} bone boxes (error {})", s.boxes.size(), static_cast<int>(error)));
  }
}
BoxTree::~BoxTree() = default;
BoxTree::BoxTree(BoxTree&&) noexcept = default;
BoxTree& BoxTree::operator=(BoxTree&&) noexcept = default;

namespace {

void QueryBoxes(RTCScene scene, const Vec3& p, double radius_mm, RTCPointQueryFunction visit, void* query) {
  RTCPointQuery embree_query;
  embree_query.x = static_cast<float>(p.x);
  embree_query.y = static_cast<float>(p.y);
  embree_query.z = static_cast<float>(p.z);
  embree_query.time = 0;
  embree_query.radius = RoundUp(radius_mm);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &embree_query, &context, visit, query);
}

}  // namespace

BoxTree::Nearest BoxTree::FindNearest(const Vec3& p_W, double limit_mm) const {
  if (state_->boxes.empty()) return {limit_mm, p_W};
  const Vec3 p = p_W - state_->middle_W;
  DistanceQuery query{state_->boxes.data(), p, state_->CalcRounding(p), limit_mm, p};
  QueryBoxes(state_->scene, p, limit_mm + query.rounding_mm, VisitForDistance, &query);
  return {query.best_mm, query.best + state_->middle_W};
}

double BoxTree::CalcPlateBound(const Plate& plate, double limit_mm, double enough_mm) const {
  if (state_->boxes.empty()) return limit_mm;
  const Vec3 p = plate.centre_W - state_->middle_W;
  const double reach_mm = std::hypot(plate.radius_mm, plate.half_thickness_mm);
  PlateQuery query{state_->boxes.data(), plate, reach_mm, enough_mm, state_->CalcRounding(p), limit_mm};
  query.plate.centre_W = p;
  QueryBoxes(state_->scene, p, limit_mm + reach_mm + query.rounding_mm, VisitForPlate, &query);
  return query.best_mm;
}

double BoxTree::CalcDistanceToAll(const Vec3& p_W) const {
  if (state_->boxes.empty()) return kInfinity;
  const Vec3 p = p_W - state_->middle_W;
  return glm::length(glm::max(glm::max(state_->all.lower - p, p - state_->all.upper), Vec3{0}));
}

std::size_t BoxTree::size() const {
  return state_->boxes.size();
}

std::size_t BoxTree::CalcMemoryBytes() const {
  return sizeof(State) + state_->boxes.capacity() * sizeof(FloatBox) +
         static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, state_->embree_bytes));
}

}  // namespace kerf
