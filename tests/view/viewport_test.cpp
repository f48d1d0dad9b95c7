// Pixels of the window that are known beforehand. With KERF_VIEW_PICTURES=folder in the environment the pictures are
// left there to be looked at.
#include "view/viewport.h"

#include <gtest/gtest.h>
#include <vtkRenderWindow.h>

#include <cstdlib>
#include <glm/geometric.hpp>

#include "models/mandible.h"
#include "render/offscreen.h"
#include "support/chunks.h"
#include "support/view_scene.h"
#include "view/surface_worker.h"

namespace kerf {
namespace {

void Leave(const Image& image, const std::string& name) {
  if (const char* folder = std::getenv("KERF_VIEW_PICTURES")) WritePng(image, std::string(folder) + "/" + name + ".png");
}

void Show(Viewport& view, SurfaceWorker& worker, const Bone& bone) {
  view.BeginBone(bone.materials(), worker.origin_W(), worker.bounds_W(), bone.voxel_mm());
  worker.WaitIdle();
  for (auto meshes = worker.Fetch(1000); !meshes.empty(); meshes = worker.Fetch(1000)) {
    for (const ChunkMesh& mesh : meshes) view.SetChunk(mesh);
  }
}

TEST(Viewport, ShowsAMandible) {
  MandibleParams params;
  params.voxel_mm = 0.3;
  const Bone bone = MakeMandible(params, DefaultMandibleTable());
  OffscreenWindow offscreen(1280, 720);
  Viewport view(offscreen.window());
  SurfaceWorker worker(bone, 2);
  Show(view, worker, bone);
  view.SetInnerSurfaces(MakeInnerSurfaces(bone));
  view.SetHud(test::MakeFullHud());
  view.SetTool(DiscSaw{});
  Pose X_WT;
  X_WT.R_AB = glm::angleAxis(1.5707963, Vec3{0, 1, 0});
  X_WT.p_AB = {30, 25, -8};
  view.SetToolPose(X_WT, 7500, 0.3);
  view.SetForce(ForceArrow{{30, 25, -19}, {0.3, 0.2, 2.2}});
  view.SetPlanes({{"plane 1", {30, 25, -20}, {1, 0.1, 0}, 40, 40, {0, 0, 1}, {0, 114, 178}, true}});
  view.SetDepthStops({{"stop 4 mm", {10, 5, -22}, {0.2, -0.5, 0.8}, 12, false}});
  view.SetMeasures({{{{-40, 40, 0}, {40, 40, 0}}, "80.0 mm"}});
  view.camera().Look(View::kThreeQuarter);
  view.FitAll();
  view.Render();
  Leave(view.Grab(), "plain");
  view.set_translucent(true);
  view.Render();
  Leave(view.Grab(), "translucent");
  view.set_translucent(false);
  view.set_colour_by(ColourBy::kRegion);
  HudState hud = test::MakeFullHud();
  hud.banner = HudBanner{HudBanner::Kind::kQuestion, "Delete the piece \"body\"?", "Y yes    N no"};
  view.SetHud(hud);
  view.Render();
  Leave(view.Grab(), "regions");
  view.Resize(2560, 1440, 2);
  view.SetHud(hud);
  view.FitAll();
  view.Render();
  Leave(view.Grab(), "regions2x");
  hud = {};
  hud.show_help = true;
  hud.help = test::MakeHelp();
  view.SetHud(hud);
  view.Render();
  Leave(view.Grab(), "help2x");
  EXPECT_GT(view.stats().drawn, 50u);
}

}  // namespace
}  // namespace kerf
