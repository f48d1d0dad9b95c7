// What SceneActors keeps, for the files that implement it: scene_actors.cpp and tool_actors.cpp.
#pragma once

#include <vtkActor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"
#include "view/live/overlays.h"
#include "view/live/scene_actors.h"
#include "view/picture/colours.h"

namespace kerf {

struct SceneActors::State {
  using Actors = std::vector<vtkSmartPointer<vtkActor>>;

  State(vtkRenderer& s, vtkRenderer& o) : scene(s), over(o) {}

  vtkRenderer& scene;
  vtkRenderer& over;
  double scale = 1;
  Actors inner;
  Box3 inner_box;
  bool inner_shown = false;
  std::optional<Tool> tool;
  std::vector<Vec3> outline_T;  // of the tool
  Pose X_WT;
  double rpm = 0;
  double angle_rad = 0;
  double displacement_mm = 0;  // of a stroke
  vtkSmartPointer<vtkActor> toothed, turning, blur, passed, passed_rim, ghost, handpiece, guard, turn_arrow;
  bool handpiece_shown = true;
  bool handpiece_in_bone = false;
  std::optional<Vec3> contact_W;
  bool tool_is_last = true;
  bool ghost_shown = false;
  std::optional<ForceArrow> force;
  Vec3 force_tail_W{0};
  vtkSmartPointer<vtkActor> arrow;
  std::vector<PlaneOverlay> planes;
  std::vector<DepthStopOverlay> stops;
  std::vector<GuideOverlay> guides;
  std::vector<MeasureOverlay> measures;
  std::vector<BridgeOverlay> bridges;
  std::vector<PointOverlay> points;
  std::vector<PlaneHandleOverlay> handles;
  std::vector<PlaneLineOverlay> plane_lines;
  std::vector<MarkOverlay> marks;
  std::vector<AlarmOverlay> alarms;
  Actors plane_actors, stop_actors, guide_actors, mark_actors;
  std::vector<PieceShape> pieces;
  struct PieceActor {
    std::shared_ptr<const TriangleMesh> mesh;
    std::shared_ptr<const std::vector<Rgb8>> colours;
    vtkSmartPointer<vtkActor> actor;
    vtkSmartPointer<vtkActor> frame;
    Box3 box;
  };
  std::map<int, PieceActor> piece_actors;

  std::uint64_t changes = 0;

  /// Sets a value. Returns false if it is the same as before.
  template <typename T>
  bool Renew(T& kept, const T& next) {
    if (kept == next) return false;
    kept = next;
    ++changes;
    return true;
  }
  /// Whether teeth pass too fast to be seen separately; they are drawn blurred.
  bool Whirls() const;
  void Remove(vtkRenderer& from, Actors& actors);
  void Add(vtkRenderer& to, Actors& actors, const vtkSmartPointer<vtkActor>& actor);
  std::vector<vtkActor*> ToolActors() const;
  /// Turns the guard to the side away from the cut; without a cut, upwards. Shows the sense in which the tool turns.
  void PlaceHandpiece();
  void ShowTool();
  /// Pose of the blade where its stroke has it.
  Pose EdgePose() const;
};

}  // namespace kerf
