#define GL_GLEXT_PROTOTYPES
#include "view/live/xray_prop.h"

#include <GL/glcorearb.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>
#include <vtkOpenGLState.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "shaders.h"
#include "view/live/vertex_stream.h"

namespace kerf {

vtkStandardNewMacro(XrayProp);

namespace {

constexpr double kDash_points = 9;

struct XrayVertex {
  float clip[3];
  float tint[4];
  float edge[4];
};

using Vec2 = glm::dvec2;

// A point on the screen, in pixels from the bottom left, with its depth from -1 to 1.
struct OnScreen {
  Vec2 px;
  double depth;
};

// Projects points as VTK does, and collects triangles.
class XrayBuilder {
 public:
  XrayBuilder(vtkRenderer& renderer, double scale, std::vector<XrayVertex>& vertices)
      : scale_(scale), vertices_(vertices) {
    vtkCamera& camera = *renderer.GetActiveCamera();
    vtkMatrix4x4::DeepCopy(clip_, camera.GetCompositeProjectionTransformMatrix(renderer.GetTiledAspectRatio(), -1, 1));
    parallel_ = camera.GetParallelProjection() != 0;
    double eye[3], along[3];
    camera.GetPosition(eye);
    camera.GetDirectionOfProjection(along);
    eye_W_ = {eye[0], eye[1], eye[2]};
    toward_eye_W_ = {-along[0], -along[1], -along[2]};
    const int* size = renderer.GetVTKWindow()->GetSize();
    size_px_ = {size[0], size[1]};
  }

  void Add(const XrayPatch& patch) {
    std::vector<std::optional<OnScreen>> at;
    for (const Vec3& p : patch.points_W) at.push_back(Project(p, patch.towards_eye_mm));
    for (const auto& t : patch.triangles) {
      if (std::any_of(t.begin(), t.end(), [&](std::uint32_t i) { return i >= at.size() || !at[i]; })) continue;
      for (const std::uint32_t i : t) AddVertex(*at[i], patch.style, 0, 1e6, 0);
    }
  }

  void Add(const XrayLine& line) {
    std::vector<OnScreen> run;
    for (const Vec3& p : line.points_W) {
      const std::optional<OnScreen> at = Project(p, line.towards_eye_mm);
      if (!at) {
        AddRun(run, line);
        run.clear();
      } else if (run.empty() || glm::length(at->px - run.back().px) > 0.3) {
        run.push_back(*at);
      }
    }
    AddRun(run, line);
  }

  void Add(const XraySymbol& symbol) {
    const std::optional<OnScreen> at = Project(symbol.p_W, symbol.towards_eye_mm);
    if (!at) return;
    const double r = 0.5 * symbol.size_points * scale_;
    switch (symbol.shape) {
      case XrayShape::kDisc:
      case XrayShape::kRing: {
        const double width = symbol.shape == XrayShape::kRing ? 2.4 * scale_ : r;
        AddRing(*at, r, width, symbol.style);
        break;
      }
      case XrayShape::kSquare:
        AddQuad(*at, {{-r, -r}, {r, -r}, {r, r}, {-r, r}}, symbol.style);
        break;
      case XrayShape::kDiamond:
        AddQuad(*at, {{0, -1.25 * r}, {1.25 * r, 0}, {0, 1.25 * r}, {-1.25 * r, 0}}, symbol.style);
        break;
      case XrayShape::kCross: {
        const double w = std::max(1.1 * scale_, 0.16 * r);
        AddQuad(*at, {{-r, -w}, {r, -w}, {r, w}, {-r, w}}, symbol.style);
        AddQuad(*at, {{-w, -r}, {w, -r}, {w, r}, {-w, r}}, symbol.style);
        break;
      }
    }
  }

 private:
  std::optional<OnScreen> Project(const Vec3& p_W, double towards_eye_mm) const {
    const auto clip = [&](const Vec3& p, int row) {
      return clip_[4 * row] * p.x + clip_[4 * row + 1] * p.y + clip_[4 * row + 2] * p.z + clip_[4 * row + 3];
    };
    const double w = clip(p_W, 3);
    if (!parallel_ && w <= 1e-6) return std::nullopt;  // behind the eye
    OnScreen at;
    at.px = 0.5 * (Vec2{clip(p_W, 0), clip(p_W, 1)} / w + 1.0) * size_px_;
    Vec3 nearer = p_W;
    if (towards_eye_mm > 0) {
      const Vec3 to_eye = parallel_ ? toward_eye_W_ : eye_W_ - p_W;
      const double far = glm::length(to_eye);
      if (far > towards_eye_mm || parallel_) nearer += towards_eye_mm / std::max(far, 1e-9) * to_eye;
    }
    at.depth = clip(nearer, 2) / clip(nearer, 3);
    // A point in front of the near plane or beyond the far plane is drawn all the same.
    at.depth = std::clamp(at.depth, -0.999999, 0.999999);
    return at;
  }

  void AddVertex(const OnScreen& at, const XrayStyle& style, double across, double half, double along) {
    const auto f = [](double v) { return static_cast<float>(v); };
    const Vec2 ndc = 2.0 * at.px / size_px_ - 1.0;
    const double hidden = style.dashed ? -style.hidden_alpha : style.hidden_alpha;
    vertices_.push_back(
        {{f(ndc.x), f(ndc.y), f(at.depth)},
         {f(style.colour[0] / 255.0), f(style.colour[1] / 255.0), f(style.colour[2] / 255.0), f(style.alpha)},
         {f(across), f(half), f(along), f(hidden)}});
  }

  // A line as a strip whose corners are mitred, with half a pixel on each side for smooth edges.
  void AddRun(const std::vector<OnScreen>& run, const XrayLine& line) {
    if (run.size() < 2) return;
    const double half = 0.5 * line.width_points * scale_;
    const double wide = half + 0.75;
    const bool closed = run.size() > 3 && glm::length(run.front().px - run.back().px) < 0.5;
    const auto direction = [&](std::size_t i) { return glm::normalize(run[i + 1].px - run[i].px); };
    const auto normal = [](const Vec2& d) { return Vec2{-d.y, d.x}; };
    std::vector<Vec2> side(run.size());
    std::vector<double> along(run.size(), 0);
    for (std::size_t i = 0; i < run.size(); ++i) {
      const bool first = i == 0;
      const bool last = i + 1 == run.size();
      const Vec2 before = first ? (closed ? direction(run.size() - 2) : direction(0)) : direction(i - 1);
      const Vec2 after = last ? (closed ? direction(0) : before) : direction(i);
      const Vec2 sum = normal(before) + normal(after);
      const double length = glm::length(sum);
      side[i] = length > 0.5 ? sum / length * std::min(2.0, 2 / length) : normal(after);
      if (!first) along[i] = along[i - 1] + glm::length(run[i].px - run[i - 1].px);
    }
    for (std::size_t i = 0; i + 1 < run.size(); ++i) {
      for (const int corner : {0, 1, 3, 0, 3, 2}) {
        const std::size_t k = i + static_cast<std::size_t>(corner / 2);
        const double sign = corner % 2 == 0 ? -1 : 1;
        OnScreen at = run[k];
        at.px += sign * wide * side[k];
        AddVertex(at, line.style, sign * wide, half, along[k]);
      }
    }
  }

  void AddQuad(const OnScreen& at, const Vec2 (&corners)[4], const XrayStyle& style) {
    for (const int i : {0, 1, 2, 0, 2, 3}) {
      OnScreen corner = at;
      corner.px += corners[i];
      AddVertex(corner, style, 0, 1e6, 0);
    }
  }

  void AddRing(const OnScreen& at, double radius, double width, const XrayStyle& style) {
    constexpr int kCorners = 32;
    // `across` is measured from the middle of the ring's width; of a disc, from its centre.
    const bool disc = width >= radius;
    const double half = disc ? radius : 0.5 * width;
    const double inner = disc ? 0 : std::max(0.0, radius - width - 0.75);
    const double outer = radius + 0.75;
    const auto corner = [&](double r, int i) {
      const double angle = 2 * std::numbers::pi * i / kCorners;
      OnScreen p = at;
      p.px += r * Vec2{std::cos(angle), std::sin(angle)};
      AddVertex(p, style, disc ? r : r - (radius - half), half, 0);
    };
    for (int i = 0; i < kCorners; ++i) {
      corner(inner, i);
      corner(outer, i);
      corner(outer, i + 1);
      if (disc) continue;
      corner(inner, i);
      corner(outer, i + 1);
      corner(inner, i + 1);
    }
  }

  double scale_;
  std::vector<XrayVertex>& vertices_;
  double clip_[16];
  bool parallel_ = false;
  Vec3 eye_W_{0};
  Vec3 toward_eye_W_{0, 0, 1};
  Vec2 size_px_{1, 1};
};

}  // namespace

struct XrayProp::State {
  XrayList list;
  double scale = 1;
  VertexStream stream{"xray", shaders::kXrayVert, shaders::kXrayFrag, {3, 4, 4}};
  std::vector<XrayVertex> vertices;
};

XrayProp::XrayProp() : state_(std::make_unique<State>()) {}
XrayProp::~XrayProp() = default;

void XrayProp::SetList(XrayList list, double scale) {
  state_->list = std::move(list);
  state_->scale = scale;
}

int XrayProp::RenderOverlay(vtkViewport* viewport) {
  State& s = *state_;
  auto* renderer = vtkOpenGLRenderer::SafeDownCast(viewport);
  if (renderer == nullptr || s.list.empty()) return 0;
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  if (window == nullptr) return 0;
  s.vertices.clear();
  XrayBuilder builder(*renderer, s.scale, s.vertices);
  for (const XrayPatch& patch : s.list.patches) builder.Add(patch);
  for (const XrayLine& line : s.list.lines) builder.Add(line);
  for (const XraySymbol& symbol : s.list.symbols) builder.Add(symbol);
  if (s.vertices.empty()) return 0;
  s.stream.Begin(*window, std::as_bytes(std::span(s.vertices)));
  const GlProgram& program = s.stream.program();
  glUniform1f(program.Uniform("dash_px"), static_cast<float>(kDash_points * s.scale));
  const int hidden = program.Uniform("hidden");
  vtkOpenGLState& state = *window->GetState();
  state.vtkglDisable(GL_CULL_FACE);
  const auto count = static_cast<GLsizei>(s.vertices.size());
  for (const bool behind : {true, false}) {
    state.vtkglDepthFunc(behind ? GL_GREATER : GL_LEQUAL);
    glUniform1f(hidden, behind ? 1.0F : 0.0F);
    glDrawArrays(GL_TRIANGLES, 0, count);
  }
  s.stream.End(*window);
  return 1;
}

void XrayProp::ReleaseGraphicsResources(vtkWindow* window) {
  state_->stream.Release();
  Superclass::ReleaseGraphicsResources(window);
}

}  // namespace kerf
