#include "kerf/tool.h"

#include "cut/tool/kinds.h"
#include "cut/tool/sense.h"

namespace kerf {

void DiscSaw::Validate() const {
  CheckParameters(*this);
}

void BallBurr::Validate() const {
  CheckParameters(*this);
}

void ReciprocatingBlade::Validate() const {
  CheckParameters(*this);
}

void Validate(const Tool& tool) {
  std::visit([](const auto& t) { t.Validate(); }, tool);
}

ToolForm GetForm(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) { return kind.kForm; });
}

std::string DescribeTool(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.Name(t); });
}

std::string DescribeToolBriefly(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.ShortName(t); });
}

double CalcReach(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CalcReach(t); });
}

double CalcRadius(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CalcRadius(t); });
}

double CalcThickness(const Tool& tool) {
  return std::visit(
      [&](const auto& t) {
        if constexpr (requires { t.thickness_mm; }) return t.thickness_mm;
        return 0.0;
      },
      tool);
}

DriveMotion GetDrive(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) { return kind.kDrive; });
}

int GetSense(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) {
    if constexpr (kind.kDrive == DriveMotion::kRotation) return kind.kSense;
    return 1;
  });
}

double CalcStroke(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) {
    if constexpr (kind.kDrive == DriveMotion::kStroke) return kind.CalcStroke(t);
    return 0.0;
  });
}

double CalcSwingRadius(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) {
    if constexpr (kind.kDrive == DriveMotion::kStroke) return kind.CalcSwingRadius(t);
    return 0.0;
  });
}

Range CalcRateRange(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) {
    if constexpr (requires { kind.kRates_per_min; }) return kind.kRates_per_min;
    return kSpindleRange_rpm;
  });
}

double CalcOrdinaryRate(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) { return kind.kOrdinaryRate_per_min; });
}

double CalcCutWidth(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CalcCutWidth(t); });
}

int CountPassesPerTurn(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CountPassesPerTurn(t); });
}

Tooth CalcTooth(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto& t) { return kind.CalcTooth(t); });
}

double CalcModulus(const Tool& tool) {
  return std::visit([](const auto& t) { return t.E_MPa; }, tool);
}

double CalcPoissonRatio(const Tool& tool) {
  return std::visit([](const auto& t) { return t.nu; }, tool);
}

double CalcRake(const Tool& tool) {
  return std::visit([](const auto& t) { return t.rake_deg; }, tool);
}

Vec3 CalcGrip(const Tool& tool) {
  return std::visit([](const auto& t) { return t.p_TG_mm; }, tool);
}

}  // namespace kerf
