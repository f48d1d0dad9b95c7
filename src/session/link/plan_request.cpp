#include "session/link/plan_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "base/core/printable.h"
#include "base/files/markups.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kReach_mm = 1000;
constexpr double kSamePoint_mm = 0.01;
constexpr std::size_t kNameBytes = 20;  // of a message

void CheckNear(const Vec3& p_W, const Box3& bone_W, const std::string& name) {
  const Vec3 outside = glm::max(glm::max(bone_W.lower - p_W, p_W - bone_W.upper), Vec3(0));
  if (glm::length(outside) <= kReach_mm) return;
  throw Error(
      fmt::format("'{}' is {:.0f} mm away from the bone; the limit is {:g} mm", name, glm::length(outside), kReach_mm));
}

/// Returns the item of that name. `name` may be a longer name that was cut off, if only one begins with it.
template <typename Item>
Item* Find(std::vector<Item>& items, const std::string& name, bool cut_off) {
  const auto same = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  if (same != items.end()) return &*same;
  if (!cut_off) return nullptr;
  const auto begins = [&](const Item& item) { return item.name.starts_with(name); };
  const auto first = std::find_if(items.begin(), items.end(), begins);
  return std::count_if(items.begin(), items.end(), begins) == 1 ? &*first : nullptr;
}

void CheckNerve(const Mark& nerve) {
  const std::vector<Vec3>& points_W = nerve.points_W;
  const auto is_elsewhere = [&](const Vec3& p_W) { return glm::length(p_W - points_W.front()) > kSamePoint_mm; };
  if (std::any_of(points_W.begin(), points_W.end(), is_elsewhere)) return;
  throw Error(fmt::format("the nerve '{}' needs at least two points at different places", nerve.name));
}

void MovePlane(const PlanRequest& request, Plan& plan, bool cut_off) {
  PlannedPlane* plane = Find(plan.planes, request.name, cut_off);
  const bool is_new = plane == nullptr;
  if (is_new && !request.adds) {
    throw Error(fmt::format("the plan has no plane '{}'; the name '{}{}' would add one", request.name, kPlanPrefix,
                            request.name));
  }
  if (is_new) {
    if (Printable(request.name) != request.name) {
      throw Error(fmt::format("the name of the new plane '{}' is no text in UTF-8", Printable(request.name)));
    }
    plan.planes.push_back({.name = request.name});
    plane = &plan.planes.back();
  }
  if (request.X_WP) {
    plane->plane = {request.X_WP->p_AB, glm::normalize(request.X_WP->Vector({0, 0, 1}))};
    plane->up_W = request.X_WP->Vector({0, -1, 0});  // ReadIgtlTransform() has turned the y axis of the message
    return;
  }
  CutPlane fitted = FitPlane(request.points_W, fmt::format("plane '{}'", request.name));
  if (!is_new && glm::dot(fitted.normal_W, plane->plane.normal_W) < 0) fitted.normal_W = -fitted.normal_W;
  plane->plane = fitted;
}

}  // namespace

PlanRequest ReadPlanRequest(const IgtlHeader& header, std::span<const std::uint8_t> content, const Box3& bone_W) {
  PlanRequest request{.name = header.device};
  if (request.name.starts_with(kPlanPrefix)) {
    request.name.erase(0, kPlanPrefix.size());
    request.adds = true;
  }
  if (request.name.find_first_not_of(' ') == std::string::npos)
    throw Error(fmt::format("a message of type {} does not name a plane", header.type));
  if (header.type == "TRANSFORM") {
    request.X_WP = ReadIgtlTransform(content);
    CheckNear(request.X_WP->p_AB, bone_W, request.name);
    return request;
  }
  request.points_W = ReadIgtlPoints(content);
  if (request.points_W.size() > kMaxMarkPoints) {
    throw Error(
        fmt::format("'{}' has {} points; the limit is {}", request.name, request.points_W.size(), kMaxMarkPoints));
  }
  for (const Vec3& p_W : request.points_W) CheckNear(p_W, bone_W, request.name);
  return request;
}

void Apply(const PlanRequest& request, Plan& plan, std::vector<Mark>& marks) {
  const std::size_t room = kNameBytes - (request.adds ? kPlanPrefix.size() : 0);
  const bool cut_off = request.name.size() == room;
  Plan next_plan = plan;
  std::vector<Mark> next_marks = marks;
  Mark* mark = request.X_WP ? nullptr : Find(next_marks, request.name, cut_off);
  if (mark == nullptr && !request.X_WP && request.name == kNerveName) {
    mark = &next_marks.emplace_back(Mark{.name = request.name, .kind = MarkKind::kNerve});
  }
  if (mark != nullptr) {
    mark->points_W = request.points_W;
    if (mark->kind == MarkKind::kNerve) CheckNerve(*mark);
  } else {
    MovePlane(request, next_plan, cut_off);
  }
  CheckPlan(next_plan);
  CheckMarks(next_marks);
  plan = std::move(next_plan);
  marks = std::move(next_marks);
}

void PlanInbox::Open(const Box3& bone_W) {
  const std::lock_guard lock(mutex_);
  bone_W_ = bone_W;
}

void PlanInbox::Close() {
  const std::lock_guard lock(mutex_);
  bone_W_.reset();
  waiting_.clear();
}

void PlanInbox::Take(const IgtlHeader& header, std::span<const std::uint8_t> content) {
  const std::lock_guard lock(mutex_);
  if (!bone_W_) throw Error("the plan of this session cannot be changed now; 'kerf rehearse' with a bone accepts that");
  PlanRequest request = ReadPlanRequest(header, content, *bone_W_);
  const std::string key = fmt::format("{} {}", header.type, header.device);
  const auto same = std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& w) { return w.first == key; });
  if (same != waiting_.end()) {
    same->second = std::move(request);
    return;
  }
  if (waiting_.size() >= kMaxPlanned) throw Error(fmt::format("more than {} changes of the plan wait", kMaxPlanned));
  waiting_.emplace_back(key, std::move(request));
}

std::vector<PlanRequest> PlanInbox::Fetch() {
  const std::lock_guard lock(mutex_);
  std::vector<PlanRequest> all;
  for (auto& [key, request] : waiting_) all.push_back(std::move(request));
  waiting_.clear();
  return all;
}

}  // namespace kerf
