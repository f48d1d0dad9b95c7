#define GL_GLEXT_PROTOTYPES
#include "view/live/dust_prop.h"

#include <GL/glcorearb.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>

#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "shaders.h"
#include "view/live/gl_program.h"
#include "view/live/vertex_stream.h"

namespace kerf {

vtkStandardNewMacro(DustProp);

namespace {

constexpr Rgb8 kDustColour{252, 246, 230};
constexpr double kSmallest_points = 1.6;
constexpr double kLargest_points = 7;

struct DustVertex {
  float p_mm[3];
  float size_alpha[2];
};

}  // namespace

struct DustProp::State {
  std::vector<DustGrain> grains;
  double scale = 1;
  VertexStream stream{"dust", shaders::kDustVert, shaders::kDustFrag, {3, 2}};
  std::vector<DustVertex> vertices;
};

DustProp::DustProp() : state_(std::make_unique<State>()) {}
DustProp::~DustProp() = default;

void DustProp::SetGrains(std::vector<DustGrain> grains, double scale) {
  state_->grains = std::move(grains);
  state_->scale = scale;
}

int DustProp::RenderOpaqueGeometry(vtkViewport* viewport) {
  State& s = *state_;
  auto* renderer = vtkOpenGLRenderer::SafeDownCast(viewport);
  if (renderer == nullptr || s.grains.empty()) return 0;
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  if (window == nullptr) return 0;
  const auto f = [](double v) { return static_cast<float>(v); };
  // Relative to the first grain, because single precision is not sufficient far from the world's origin.
  const Vec3 origin_W = s.grains.front().p_W;
  s.vertices.clear();
  for (const DustGrain& grain : s.grains) {
    const Vec3 p = grain.p_W - origin_W;
    s.vertices.push_back({{f(p.x), f(p.y), f(p.z)}, {f(grain.diameter_mm), f(grain.opacity)}});
  }
  vtkCamera& camera = *renderer->GetActiveCamera();
  double view[16];
  vtkMatrix4x4::DeepCopy(view, camera.GetViewTransformMatrix());
  double clip[16];
  vtkMatrix4x4::DeepCopy(clip, camera.GetProjectionTransformMatrix(renderer->GetTiledAspectRatio(), -1, 1));
  for (int i = 0; i < 3; ++i) {
    view[4 * i + 3] += view[4 * i] * origin_W.x + view[4 * i + 1] * origin_W.y + view[4 * i + 2] * origin_W.z;
  }
  const bool parallel = camera.GetParallelProjection() != 0;
  const double height_px = window->GetSize()[1];
  const double tan_half = std::tan(0.5 * camera.GetViewAngle() * std::numbers::pi / 180);
  s.stream.Begin(*window, std::as_bytes(std::span(s.vertices)));
  const GlProgram& program = s.stream.program();
  glUniformMatrix4fv(program.Uniform("view_from_world"), 1, GL_FALSE, ToGl(view).data());
  glUniformMatrix4fv(program.Uniform("clip_from_view"), 1, GL_FALSE, ToGl(clip).data());
  glUniform1f(program.Uniform("px_per_mm"), f(0.5 * height_px / (parallel ? camera.GetParallelScale() : tan_half)));
  glUniform1f(program.Uniform("parallel"), parallel ? 1.0F : 0.0F);
  glUniform2f(program.Uniform("size_px"), f(kSmallest_points * s.scale), f(kLargest_points * s.scale));
  glUniform3f(program.Uniform("tint"), f(kDustColour[0] / 255.0), f(kDustColour[1] / 255.0), f(kDustColour[2] / 255.0));
  glEnable(GL_PROGRAM_POINT_SIZE);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(s.vertices.size()));
  glDisable(GL_PROGRAM_POINT_SIZE);
  s.stream.End(*window);
  return 1;
}

void DustProp::ReleaseGraphicsResources(vtkWindow* window) {
  state_->stream.Release();
  Superclass::ReleaseGraphicsResources(window);
}

}  // namespace kerf
