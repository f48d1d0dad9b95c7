#include "bone/pieces/surface_tree.h"

#include <rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kRounding = 1e-6;  // bound on the error of single precision, relative to the sizes involved

struct Query {
  const std::vector<Vec3>* points;
  const std::vector<std::array<std::uint32_t, 3>>* triangles;
  Vec3 p;
  double rounding_mm;
  double best_mm;
  std::uint32_t triangle;
  Vec3 best;
  bool found;
};

float RoundUp(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

bool Visit(RTCPointQueryFunctionArguments* args) {
  auto& q = *static_cast<Query*>(args->userPtr);
  const auto& t = (*q.triangles)[args->primID];
  const Vec3 at = FindNearestInTriangle(q.p, (*q.points)[t[0]], (*q.points)[t[1]], (*q.points)[t[2]]);
  const double distance = glm::length(at - q.p);
  // Of two equally near triangles, the one with the lower index is chosen, so that the result does not depend on the
  // tree.
  if (distance > q.best_mm || (distance == q.best_mm && (!q.found || args->primID > q.triangle))) return false;
  q.best_mm = distance;
  q.triangle = args->primID;
  q.best = at;
  q.found = true;
  args->query->radius = RoundUp(distance + q.rounding_mm);
  return true;
}

}  // namespace

Vec3 FindNearestInTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  // The nearest point depends on the region of the triangle's plane that p projects to (Ericson, Real-Time Collision
  // Detection, 5.1.5).
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double d1 = glm::dot(ab, ap);
  const double d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = glm::dot(ab, bp);
  const double d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = glm::dot(ab, cp);
  const double d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

struct SurfaceTree::State {
  ~State() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
  std::vector<Vec3> points;  // relative to the centre
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Box3 bounds;
  Vec3 middle{0};
  double size_mm = 0;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

SurfaceTree::SurfaceTree(const TriangleMesh& mesh) : state_(std::make_unique<State>()) {
  State& s = *state_;
  for (const Vec3& p : mesh.points) s.bounds.Include(p);
  s.middle = mesh.points.empty() ? Vec3(0) : s.bounds.centre();
  s.size_mm = glm::length(s.bounds.size());
  s.triangles = mesh.triangles;
  s.points.reserve(mesh.points.size());
  for (const Vec3& p : mesh.points) s.points.push_back(p - s.middle);
  s.device = rtcNewDevice("threads=1,tessellation_cache_size=0");
  if (!s.device) throw Error("Embree can't be set up");
  s.scene = rtcNewScene(s.device);
  if (!s.scene) throw Error("Embree can't make a scene");
  rtcSetSceneFlags(s.scene, RTC_SCENE_FLAG_ROBUST);
  if (!s.triangles.empty()) {
    RTCGeometry geometry = rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), s.points.size()));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), s.triangles.size()));
    if (!vertices || !indices) {
      rtcReleaseGeometry(geometry);
      throw Error("Embree ran out of memory for a surface");
    }
    for (const Vec3& p : s.points) {
      for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(p[i]);
    }
    for (const auto& t : s.triangles) indices = std::copy(t.begin(), t.end(), indices);
    rtcSetGeometryPointQueryFunction(geometry, Visit);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(s.scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(s.scene);
  if (rtcGetDeviceError(s.device) != RTC_ERROR_NONE) throw Error("Embree can't load the surface");
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree& SurfaceTree::operator=(SurfaceTree&&) noexcept = default;

const Box3& SurfaceTree::bounds() const {
  return state_->bounds;
}

std::optional<SurfaceTree::Hit> SurfaceTree::Intersect(const Vec3& origin, const Vec3& direction) const {
  const State& s = *state_;
  const double length = glm::length(direction);
  if (!(length > 0) || s.triangles.empty()) return {};
  const Vec3 d = direction / length;
  // The ray starts near the surface, because single precision is not sufficient for a distant camera.
  const double start = std::max(0.0, glm::dot(s.middle - origin, d) - s.size_mm);
  const Vec3 from = origin + start * d - s.middle;
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(from.x);
  ray.ray.org_y = static_cast<float>(from.y);
  ray.ray.org_z = static_cast<float>(from.z);
  ray.ray.dir_x = static_cast<float>(d.x);
  ray.ray.dir_y = static_cast<float>(d.y);
  ray.ray.dir_z = static_cast<float>(d.z);
  ray.ray.tnear = 0;
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(s.scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(s.scene, &context, &ray);
#endif
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const auto& t = s.triangles[ray.hit.primID];
  const auto u = static_cast<double>(ray.hit.u);
  const auto v = static_cast<double>(ray.hit.v);
  const Vec3 p = (1 - u - v) * s.points[t[0]] + u * s.points[t[1]] + v * s.points[t[2]];
  return Hit{.distance_mm = start + static_cast<double>(ray.ray.tfar), .p = p + s.middle, .triangle = ray.hit.primID};
}

std::optional<SurfaceTree::Nearest> SurfaceTree::FindNearest(const Vec3& p, double limit_mm) const {
  const State& s = *state_;
  if (s.triangles.empty()) return {};
  const Vec3 at = p - s.middle;
  Query q{.points = &s.points,
          .triangles = &s.triangles,
          .p = at,
          .rounding_mm = kRounding * (glm::length(at) + s.size_mm) + kRounding,
          .best_mm = limit_mm,
          .triangle = 0,
          .best = Vec3(0),
          .found = false};
  RTCPointQuery query{};
  query.x = static_cast<float>(at.x);
  query.y = static_cast<float>(at.y);
  query.z = static_cast<float>(at.z);
  query.radius = RoundUp(limit_mm + q.rounding_mm);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(s.scene, &query, &context, nullptr, &q);
  if (!q.found) return {};
  return Nearest{.distance_mm = q.best_mm, .p = q.best + s.middle, .triangle = q.triangle};
}

}  // namespace kerf
