// Interface of a kind of tool: what contact, removal, effects and measures need of it. A new kind needs its parameters
// and a place in Tool (include/kerf/tool.h), a file here that specialises ToolKind, with a line in kinds.h, and its
// sweep (sweeps-inl.h). A missing part does not compile.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cut/tool/convex_outline.h"
#include "cut/tool/looks.h"
#include "cut/tool/round_solid.h"
#include "cut/tool/shape.h"
#include "cut/tool/words.h"
#include "kerf/tool.h"

namespace kerf {

/// Specialised for each alternative of Tool, with the members that IsToolKind lists. Their meanings:
///
/// kShape, kSummary: the word for the kind in scenes, and what it is.
/// kClass, kFrame: name of its class in Python, and where the tool frame lies.
/// kForm: the form of the tool.
/// kWords: GetWords().
/// kDrive: how its edge moves. With DriveMotion::kRotation also kSense: GetSense(). With DriveMotion::kStroke also
/// CalcStroke() and CalcSwingRadius(), as the functions of kerf/tool.h, and Make(), a PlanarBlade: planar_blade.h gives
/// most of what follows.
/// kRates_per_min: speeds that users may set as `rpm`, if not those of a spindle.
/// kOrdinaryRate_per_min: CalcOrdinaryRate(); one of the rates of the kind in volumes/saws.csv, with their sources.
/// CalcReach(), CalcRadius(), CalcCutWidth(), CountPassesPerTurn(): as the functions of kerf/tool.h.
/// Name(), ShortName(): a description with all measures of the shape, and one with the most important.
/// CalcTooth(): dimensions of a tooth.
/// CalcSideStiffness(): of a blade, force at the rim per displacement of the rim out of its plane, N/mm; 0: rigid.
/// CalcRoundSolid(): the body of a tool of the form kRound; none for other forms.
/// FindNearest(): point of the body nearest to a point; the point itself inside. The body must be convex.
/// CalcSignedDistance(): distance from the body's surface, mm; negative inside, where it need not be exact.
/// FindDeepest(): point of the edge that lies furthest along a direction of any length; the origin if no point does.
/// MakeShape(): as MakeToolShape(), without reach_mm.
/// MakeCover(): as MakeToolCover().
/// MakeLooks(), MakeSection(): as MakeToolLooks() and MakeToolSection().
/// SampleSurface(): as SampleToolSurface().
template <typename T>
struct ToolKind;

template <typename T>
concept HasDrive = requires {
  requires ToolKind<T>::kSense == 1 || ToolKind<T>::kSense == -1;
}
|| requires(const T& tool) {
  { ToolKind<T>::CalcStroke(tool) } -> std::same_as<double>;
  { ToolKind<T>::CalcSwingRadius(tool) } -> std::same_as<double>;
  ToolKind<T>::Make(tool);
};

template <typename T>
concept IsToolKind = HasDrive<T> &&
    requires(const T& tool, const Vec3& p_T, const Pose& X_ST, const ShapeSampling& sampling) {
  { ToolKind<T>::kShape } -> std::convertible_to<std::string_view>;
  { ToolKind<T>::kSummary } -> std::convertible_to<std::string_view>;
  { ToolKind<T>::kClass } -> std::convertible_to<std::string_view>;
  { ToolKind<T>::kFrame } -> std::convertible_to<std::string_view>;
  { ToolKind<T>::kForm } -> std::convertible_to<ToolForm>;
  { ToolKind<T>::kWords } -> std::convertible_to<ToolWords>;
  { ToolKind<T>::kOrdinaryRate_per_min } -> std::convertible_to<double>;
  { ToolKind<T>::Name(tool) } -> std::same_as<std::string>;
  { ToolKind<T>::ShortName(tool) } -> std::same_as<std::string>;
  { ToolKind<T>::CalcReach(tool) } -> std::same_as<double>;
  { ToolKind<T>::CalcRadius(tool) } -> std::same_as<double>;
  { ToolKind<T>::CalcCutWidth(tool) } -> std::same_as<double>;
  { ToolKind<T>::CountPassesPerTurn(tool) } -> std::same_as<int>;
  { ToolKind<T>::CalcTooth(tool) } -> std::same_as<Tooth>;
  { ToolKind<T>::CalcSideStiffness(tool) } -> std::same_as<double>;
  { ToolKind<T>::CalcRoundSolid(tool) } -> std::same_as<std::optional<RoundSolid>>;
  { ToolKind<T>::FindNearest(tool, p_T) } -> std::same_as<Vec3>;
  { ToolKind<T>::CalcSignedDistance(tool, p_T) } -> std::same_as<double>;
  { ToolKind<T>::FindDeepest(tool, p_T) } -> std::same_as<Vec3>;
  { ToolKind<T>::MakeShape(tool, sampling) } -> std::same_as<ToolShape>;
  { ToolKind<T>::MakeCover(tool) } -> std::same_as<std::vector<CoverPlate>>;
  { ToolKind<T>::MakeLooks(tool) } -> std::same_as<ToolLooks>;
  { ToolKind<T>::MakeSection(tool, X_ST, 1.0) } -> std::same_as<std::vector<Vec3>>;
  { ToolKind<T>::SampleSurface(tool, 1.0) } -> std::same_as<std::vector<Vec3>>;
};

/// Returns call(ToolKind<T>(), t) for the tool's alternative `t` of type T.
template <typename Call>
auto CallKind(const Tool& tool, Call&& call) {
  return std::visit([&call]<IsToolKind T>(const T& t) { return call(ToolKind<T>(), t); }, tool);
}

}  // namespace kerf
