#include "session/run/run_warnings.h"

#include <fmt/format.h>

#include "cut/tool/shape.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

constexpr double kHolderInBone_mm = 0.05;  // a smaller depth is that of the grid

void Append(std::vector<std::string> more, std::vector<std::string>& warnings) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

}  // namespace

std::vector<std::string> FindEffectWarnings(const EffectChoices& effects, const EffectRecord& record) {
  std::vector<std::string> warnings;
  const EffectChoice* guide = FindChoice(effects, "guide");
  for (const EffectFigure& figure : record.figures) {
    const std::string column = figure.column();
    if (column == "spindle_stalled" && figure.largest > 0) {
      warnings.emplace_back(
          "the spindle stalled, and the tool continued along its path without cutting; see spindle_stalled in "
          "forces.csv");
    }
    const auto beyond = [&](const char* what, double limit_mm) {
      if (figure.largest <= limit_mm + 1e-3) return;
      warnings.push_back(
          fmt::format("the path goes {:.3g} mm {} of the guide, which can't hold a tool that follows a path; 'kerf "
                      "loop' couples it to a handle",
                      figure.largest - limit_mm, what));
    };
    if (column == "handpiece_depth_mm" && figure.largest > kHolderInBone_mm) {
      warnings.push_back(
          fmt::format("the path takes the hub, shank or handpiece into bone, by {:.2g} mm or more, which can't hold a "
                      "tool that follows a path; 'kerf loop' couples it to a handle",
                      figure.largest));
    }
    if (column == "guide_deviation_mm") beyond("beyond the tolerance", guide->GetNumber("tolerance_mm"));
    if (column == "guide_depth_mm" && guide->GetNumber("depth_mm") > 0) {
      beyond("past the depth stop", guide->GetNumber("depth_mm"));
    }
  }
  return warnings;
}

std::string_view NameTool(const Tool& tool) {
  return IsBlade(tool) ? "saw" : GetShape(tool);
}

std::vector<std::string> FindTickWarnings(const TickFindings& ticks) {
  std::vector<std::string> warnings;
  if (!ticks.touched && !ticks.starts_in_bone) {
    warnings.push_back(ticks.removed_mm3 > 0
                           ? fmt::format("no tooth cut, but the {} went through bone and removed {:.4g} mm3 without a "
                                         "force; move it with its teeth first",
                                         ticks.tool, ticks.removed_mm3)
                           : fmt::format("the {} touched no bone on its path", ticks.tool));
  }
  if (ticks.starts_in_bone) {
    warnings.emplace_back("the tool was set down inside the bone; the bone inside it was removed at once");
  }
  if (ticks.ticks_at_metal > 0) {
    warnings.push_back(fmt::format(
        "the path leads through metal in {} ticks; a bone saw does not cut metal: it is left, and gives no force",
        ticks.ticks_at_metal));
  }
  if (ticks.ticks_with_status > ticks.ticks_at_metal) {
    warnings.push_back(fmt::format("{} ticks report that something was not done as requested; see the status column",
                                   ticks.ticks_with_status - ticks.ticks_at_metal));
  }
  return warnings;
}

std::vector<std::string> FindPieceWarnings(const Scene& scene, const PieceCounts& counts, double voxel_mm) {
  // Every cut leaves a few thin crumbs.
  if (counts.thin_count == 0 || counts.thin_mm3 < scene.output.smallest_piece_mm3) return {};
  return {fmt::format(
      "a wall is thinner than about a voxel ({:g} mm), as between two kerfs: {} pieces or crumbs of {:.3g} mm3 in "
      "total are nowhere deeper than half a voxel, and their number and shape are accidental; use smaller voxels",
      voxel_mm, counts.thin_count, counts.thin_mm3)};
}

std::vector<std::string> FindRunWarnings(const Scene& scene, const RunSummary& summary) {
  std::vector<std::string> warnings = FindWarnings(scene, summary.voxel_mm);
  Append(summary.material.warnings, warnings);
  Append(FindTickWarnings({summary.touched, summary.starts_in_bone, summary.ticks_with_status, summary.ticks_at_metal,
                           summary.removed_mm3, NameTool(scene.tool.shape)}),
         warnings);
  Append(FindEnergyWarnings(scene, summary.cutting), warnings);
  Append(FindPieceWarnings(scene, summary.piece_counts, summary.voxel_mm), warnings);
  Append(FindEffectWarnings(scene.effects, summary.effects), warnings);
  return warnings;
}

std::vector<std::string> FindSlabRunWarnings(const Scene& scene, const SlabSummary& summary) {
  std::vector<std::string> warnings = FindWarnings(scene, summary.voxel_mm);
  Append(summary.material.warnings, warnings);
  if (summary.end.deepest_mm <= 0 && scene.tool.rpm > 0 && scene.slab.hold == SlabBody::kSlice) {
    warnings.emplace_back("the blade touched no bone on its path");
  }
  if (summary.starts_in_bone) {
    warnings.emplace_back(
        "the blade was set down inside the bone; the spring of its slice is slack there, and the bone above it counts "
        "as cut");
  }
  return warnings;
}

}  // namespace kerf
