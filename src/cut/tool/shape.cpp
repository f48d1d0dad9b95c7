#include "cut/tool/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "cut/tool/kinds.h"

namespace kerf {
namespace {

template <std::size_t... kKinds>
std::vector<Tool> MakeDefaultTools(std::index_sequence<kKinds...>) {
  return {Tool(std::in_place_index<kKinds>)...};
}

}  // namespace

const std::vector<Tool>& GetDefaultTools() {
  static const std::vector<Tool> kTools = MakeDefaultTools(std::make_index_sequence<std::variant_size_v<Tool>>());
  return kTools;
}

std::string_view GetShape(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) { return kind.kShape; });
}

const std::vector<std::string_view>& GetToolShapes() {
  static const std::vector<std::string_view> kShapes = [] {
    std::vector<std::string_view> shapes;
    for (const Tool& tool : GetDefaultTools()) shapes.push_back(GetShape(tool));
    return shapes;
  }();
  return kShapes;
}

const std::string& DescribeToolShapes() {
  static const std::string kText = [] {
    std::string text;
    for (const Tool& tool : GetDefaultTools()) {
      if (!text.empty()) text += "; ";
      CallKind(tool, [&](auto kind, const auto&) { text += fmt::format("{}: {}", kind.kShape, kind.kSummary); });
    }
    return text;
  }();
  return kText;
}

ToolShape MakeToolShape(const Tool& tool, const ShapeSampling& sampling) {
  ToolShape shape = CallKind(tool, [&](auto kind, const auto& t) { return kind.MakeShape(t, sampling); });
  shape.reach_mm = CalcReach(tool);
  return shape;
}

std::vector<CoverPlate> MakeToolCover(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.MakeCover(t); });
}

std::optional<PlanarBlade> FindPlanarBlade(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) -> std::optional<PlanarBlade> {
    if constexpr (requires { kind.Make(t); }) return kind.Make(t);
    return {};
  });
}

ConvexOutline MakeToolOutline(const Tool& tool) {
  const std::optional<PlanarBlade> blade = FindPlanarBlade(tool);
  return blade ? blade->SweepOutline({}) : ConvexOutline{};
}

ConvexOutline MakeStrokeOutline(const Tool& tool) {
  const std::optional<PlanarBlade> blade = FindPlanarBlade(tool);
  return blade ? blade->SweepOutline({-0.5 * blade->stroke_mm, 0.5 * blade->stroke_mm}) : ConvexOutline{};
}

std::vector<Vec3> SampleToolSurface(const Tool& tool, double step_mm) {
  return CallKind(tool, [&](auto kind, const auto& t) { return kind.SampleSurface(t, step_mm); });
}

ToolLooks MakeToolLooks(const Tool& tool) {
  Validate(tool);
  return CallKind(tool, [](auto kind, const auto& t) { return kind.MakeLooks(t); });
}

std::vector<Vec3> MakeToolSection(const Tool& tool, const Pose& X_ST, double least_mm) {
  return CallKind(tool, [&](auto kind, const auto& t) { return kind.MakeSection(t, X_ST, least_mm); });
}

std::optional<RoundSolid> CalcRoundSolid(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CalcRoundSolid(t); });
}

double CalcSideStiffness(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CalcSideStiffness(t); });
}

Vec3 FindNearestOfTool(const Tool& tool, const Vec3& p_T) {
  return CallKind(tool, [&](auto kind, const auto& t) { return kind.FindNearest(t, p_T); });
}

double CalcSignedToolDistance(const Tool& tool, const Vec3& p_T) {
  return CallKind(tool, [&](auto kind, const auto& t) { return kind.CalcSignedDistance(t, p_T); });
}

Vec3 FindDeepest(const Tool& tool, const Vec3& n_T) {
  return CallKind(tool, [&](auto kind, const auto& t) { return kind.FindDeepest(t, n_T); });
}

double CalcPassedDistance(const Tool& tool, const Vec3& p_T) {
  const ConvexOutline outline = MakeStrokeOutline(tool);
  if (outline.empty()) return CalcToolDistance(tool, p_T);
  return std::hypot(std::max(0.0, outline.CalcSignedDistance({p_T.x, p_T.y})),
                    std::max(0.0, std::abs(p_T.z) - 0.5 * CalcCutWidth(tool)));
}

Vec3 FindForemost(const Tool& tool, const Vec3& n_T) {
  return GetDrive(tool) == DriveMotion::kStroke ? Vec3(0) : FindDeepest(tool, n_T);
}

double CalcTravel(const Pose& from, const Pose& to, double reach_mm) {
  // Half the chord between two unit quaternions (with signs chosen for the shorter one) is sin(angle / 4).
  const Quat d = glm::dot(from.R_AB, to.R_AB) < 0 ? from.R_AB + to.R_AB : from.R_AB - to.R_AB;
  const double angle = 4 * std::asin(std::min(1.0, 0.5 * std::sqrt(glm::dot(d, d))));
  return glm::length(to.p_AB - from.p_AB) + angle * reach_mm;
}

}  // namespace kerf
