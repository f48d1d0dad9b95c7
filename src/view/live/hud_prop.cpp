#define GL_GLEXT_PROTOTYPES
#include "view/live/hud_prop.h"

#include <GL/glcorearb.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>

#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "shaders.h"
#include "view/live/gl_program.h"
#include "view/live/text_atlas.h"

namespace kerf {

vtkStandardNewMacro(HudProp);

namespace {

struct Vertex {
  float at_px[2];
  float at_texel[2];
  float tint[4];
};

struct Texture {
  GLuint id = 0;
  std::uint64_t version = 0;
  bool used = false;
};

// 0: plain, 1: text, 2: image; same values as in flat.frag.
struct Run {
  int kind;
  std::size_t first;
  std::size_t count;
  std::size_t picture;
};

class Quads {
 public:
  explicit Quads(std::vector<Vertex>& vertices) : vertices_(vertices) {}

  void Add(double x, double y, double width, double height, double u, double v, double du, double dv,
           const FlatColour& colour) {
    const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (const int i : {0, 1, 2, 0, 2, 3}) {
      AddVertex(x + corners[i][0] * width, y + corners[i][1] * height, u + corners[i][0] * du, v + corners[i][1] * dv,
                colour);
    }
  }
  void AddVertex(double x, double y, double u, double v, const FlatColour& c) {
    const auto f = [](double value) { return static_cast<float>(value); };
    vertices_.push_back(
        {{f(x), f(y)}, {f(u), f(v)}, {f(c.rgb[0] / 255.0), f(c.rgb[1] / 255.0), f(c.rgb[2] / 255.0), f(c.alpha)}});
  }

 private:
  std::vector<Vertex>& vertices_;
};

}  // namespace

struct HudProp::State {
  DrawList list;
  double scale = 1;
  bool changed = true;
  GlProgram program;
  GLuint vertex_array = 0;
  GLuint buffer = 0;
  TextAtlas atlas;
  std::map<std::size_t, Texture> pictures;  // by index in the list
  std::vector<Vertex> vertices;
  std::vector<Run> runs;

  void AddText(const FlatText& text, bool& kept) {
    const int size = static_cast<int>(std::lround(text.size * scale));
    const TextAtlas::Place p = atlas.Find(text.text, size, text.bold, text.upward, kept);
    const double begin = std::round(text.x * scale);
    double x = begin + p.offset_x;
    if (!text.upward && text.align == Align::kCentre) x = std::round(begin - 0.5 * p.width);
    if (!text.upward && text.align == Align::kRight) x = begin - p.width;
    double y = std::round(text.y * scale) + p.offset_y;
    if (text.upward) {
      x = begin;
      y = std::round(text.y * scale - 0.5 * p.height);
    }
    Quads(vertices).Add(x, y, p.width, p.height, p.left, p.top, p.width, p.height, text.colour);
  }

  // Returns false if the text texture was cleared in the process, so that earlier texts are lost.
  bool MakeVertices() {
    vertices.clear();
    runs.clear();
    bool all_kept = true;
    for (const DrawList::Step& step : list.steps()) {
      const std::size_t first = vertices.size();
      if (step.kind == DrawList::Kind::kTriangles) {
        for (std::size_t i = 0; i < step.count; ++i) {
          const FlatTriangle& t = list.triangles()[step.first + i];
          for (const OverlayPoint& p : t.corners) {
            Quads(vertices).AddVertex(p.column * scale, p.row * scale, 0, 0, t.colour);
          }
        }
        runs.push_back({0, first, vertices.size() - first, 0});
      } else if (step.kind == DrawList::Kind::kText) {
        for (std::size_t i = 0; i < step.count; ++i) {
          bool kept = true;
          AddText(list.texts()[step.first + i], kept);
          all_kept = all_kept && kept;
        }
        runs.push_back({1, first, vertices.size() - first, 0});
      } else {
        for (std::size_t i = 0; i < step.count; ++i) {
          const FlatPicture& picture = list.pictures()[step.first + i];
          const std::size_t begin = vertices.size();
          Quads(vertices).Add(picture.box.left * scale, picture.box.top * scale, picture.box.width * scale,
                              picture.box.height * scale, 0, 0, picture.image->width, picture.image->height, {});
          runs.push_back({2, begin, vertices.size() - begin, step.first + i});
        }
      }
    }
    return all_kept;
  }

  void UploadPictures() {
    for (std::size_t i = 0; i < list.pictures().size(); ++i) {
      const FlatPicture& picture = list.pictures()[i];
      Texture& texture = pictures[i];
      if (texture.id != 0 && texture.version == picture.version) continue;
      if (texture.id == 0) glGenTextures(1, &texture.id);
      texture.version = picture.version;
      glBindTexture(GL_TEXTURE_2D, texture.id);
      glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.image->width, picture.image->height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                   picture.image->pixels.data());
      glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
  }
};

HudProp::HudProp() : state_(std::make_unique<State>()) {}
HudProp::~HudProp() = default;

void HudProp::SetList(DrawList list, double scale) {
  state_->list = std::move(list);
  state_->scale = scale;
  state_->changed = true;
}

int HudProp::RenderOverlay(vtkViewport* viewport) {
  State& s = *state_;
  auto* renderer = vtkOpenGLRenderer::SafeDownCast(viewport);
  if (renderer == nullptr || s.list.steps().empty()) return 0;
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  if (window == nullptr) return 0;
  vtkOpenGLState& state = *window->GetState();
  window->GetShaderCache()->ReleaseCurrentShader();
  state.vtkglActiveTexture(GL_TEXTURE0);
  if (!s.program.made()) {
    s.program.Make("flat", shaders::kFlatVert, shaders::kFlatFrag);
    glGenVertexArrays(1, &s.vertex_array);
    glGenBuffers(1, &s.buffer);
    glBindVertexArray(s.vertex_array);
    glBindBuffer(GL_ARRAY_BUFFER, s.buffer);
    const auto offset = [](std::size_t bytes) { return static_cast<const char*>(nullptr) + bytes; };
    constexpr GLsizei kStride = sizeof(Vertex);
    for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(Vertex, at_px)));
    glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(Vertex, at_texel)));
    glVertexAttribPointer(2, 4, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(Vertex, tint)));
  }
  glBindVertexArray(s.vertex_array);
  glBindBuffer(GL_ARRAY_BUFFER, s.buffer);
  if (s.changed) {
    if (!s.MakeVertices()) s.MakeVertices();
    s.UploadPictures();
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(s.vertices.size() * sizeof(Vertex)), s.vertices.data(),
                 GL_STREAM_DRAW);
    s.changed = false;
  }
  s.program.Use();
  const int* size = window->GetSize();
  glUniform2f(s.program.Uniform("window_px"), static_cast<float>(size[0]), static_cast<float>(size[1]));
  glUniform1i(s.program.Uniform("words"), 0);
  const int kind = s.program.Uniform("kind");
  const int texture_px = s.program.Uniform("texture_px");
  state.vtkglDisable(GL_DEPTH_TEST);
  state.vtkglDisable(GL_CULL_FACE);
  state.vtkglEnable(GL_BLEND);
  state.vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  for (const Run& run : s.runs) {
    glUniform1i(kind, run.kind);
    if (run.kind == 1) {
      glBindTexture(GL_TEXTURE_2D, s.atlas.texture());
      glUniform2f(texture_px, TextAtlas::kSide, TextAtlas::kSide);
    } else if (run.kind == 2) {
      const Image& image = *s.list.pictures()[run.picture].image;
      glBindTexture(GL_TEXTURE_2D, s.pictures[run.picture].id);
      glUniform2f(texture_px, static_cast<float>(image.width), static_cast<float>(image.height));
    } else {
      glUniform2f(texture_px, 1, 1);
    }
    glDrawArrays(GL_TRIANGLES, static_cast<GLint>(run.first), static_cast<GLsizei>(run.count));
  }
  state.vtkglEnable(GL_DEPTH_TEST);
  glBindTexture(GL_TEXTURE_2D, 0);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glUseProgram(0);
  return 1;
}

void HudProp::ReleaseGraphicsResources(vtkWindow* window) {
  State& s = *state_;
  s.atlas.Release();
  for (auto& [place, texture] : s.pictures) glDeleteTextures(1, &texture.id);
  s.pictures.clear();
  if (s.buffer != 0) glDeleteBuffers(1, &s.buffer);
  if (s.vertex_array != 0) glDeleteVertexArrays(1, &s.vertex_array);
  s.buffer = s.vertex_array = 0;
  s.program.Release();
  s.changed = true;
  Superclass::ReleaseGraphicsResources(window);
}

}  // namespace kerf
