#include "app/window/plan_picture.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <utility>

#include "session/plan/edit_plane.h"
#include "view/picture/colours.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Distinguishable from the blue planes, and from each other, with any colour vision.
constexpr Rgb8 kToothColour{220, 140, 0};
constexpr Rgb8 kOtherColour{0, 130, 95};

}  // namespace

Rgb8 MarkColour(MarkKind kind) {
  return IsNerve(kind) ? TissueColour(Tissue::kCanal) : IsTooth(kind) ? kToothColour : kOtherColour;
}

std::vector<PlaneOverlay> ListPlanes(const PlanDocument& document, bool faint) {
  std::vector<PlaneOverlay> planes;
  for (std::size_t i = 0; i < document.plan().planes.size(); ++i) {
    const PlannedPlane& p = document.plan().planes[i];
    planes.push_back({.name = ShowName(p.name),
                      .p_W = p.plane.p_W,
                      .normal_W = p.plane.normal_W,
                      .width_mm = p.width_mm,
                      .height_mm = p.height_mm,
                      .up_W = CalcPlaneAxes(p).up_W,
                      .selected = i == document.plane_index(),
                      .faint = faint});
  }
  return planes;
}

std::vector<MarkOverlay> ListMarks(const PlanDocument& document) {
  const std::vector<MarkTube>& tubes = document.mark_tubes();
  std::vector<MarkOverlay> marks;
  for (std::size_t i = 0; i < tubes.size(); ++i) {
    const bool is_nerve = tubes[i].kind() == MarkKind::kNerve || tubes[i].kind() == MarkKind::kCanal;
    marks.push_back({.points_W = tubes[i].curve_W(),
                     .radius_mm = tubes[i].radius_mm(),
                     .colour = MarkColour(tubes[i].kind()),
                     .label = ShowName(tubes[i].name()),
                     .selected = document.mark_index() == i,
                     .shows_through = is_nerve});
  }
  return marks;
}

void ShowPlan(ViewerApp& viewer, const PlanDocument& document, const PlanesReport* report) {
  Viewport& view = viewer.view();
  const std::vector<PlaneOverlay> planes = ListPlanes(document);
  view.SetPlanes(planes);
  viewer.RequestPlaneLines(planes);
  std::vector<DepthStopOverlay> stops;
  for (const DepthStop& stop : document.plan().stops) {
    stops.push_back({.name = ShowName(stop.name),
                     .p_W = stop.p_W_mm + stop.depth_mm * stop.direction_W,
                     .normal_W = -stop.direction_W});
  }
  view.SetDepthStops(stops);

  view.SetMarks(ListMarks(document));

  std::vector<BridgeOverlay> bridges;
  if (report != nullptr) {
    for (const PlanesReport::Row& row : report->planes) {
      // Before a plane is cut, all of it holds.
      if (row.state.fraction() < 0.02) continue;
      for (const Bridge& bridge : row.state.bridges) {
        if (bridge.area_mm2 < 0.5) continue;  // it would be shown as 0
        BridgeOverlay overlay;
        overlay.centre_W = bridge.centre_W;
        overlay.label = fmt::format(fmt::runtime(Tr("still holds: {} mm²")), ShowNumber(bridge.area_mm2, 0));
        for (const std::array<Vec3, 4>& patch : bridge.patches) {
          const auto first = static_cast<std::uint32_t>(overlay.points_W.size());
          overlay.points_W.insert(overlay.points_W.end(), patch.begin(), patch.end());
          overlay.triangles.push_back({first, first + 1, first + 2});
          overlay.triangles.push_back({first, first + 2, first + 3});
        }
        bridges.push_back(std::move(overlay));
      }
    }
  }
  view.SetBridges(bridges);
}

void HidePlan(ViewerApp& viewer) {
  HidePlanOnBone(viewer);
  viewer.view().SetPlanes({});
  viewer.view().SetDepthStops({});
  viewer.view().SetMarks({});
}

void HidePlanOnBone(ViewerApp& viewer) {
  viewer.view().SetBridges({});
  viewer.HidePlaneLines();
}

}  // namespace kerf
