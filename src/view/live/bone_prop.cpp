#define GL_GLEXT_PROTOTYPES
#include "view/live/bone_prop.h"

#include <GL/glcorearb.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "shaders.h"
#include "view/live/chunk_buffers.h"
#include "view/live/gl_program.h"
#include "view/live/lamps.h"

namespace kerf {

vtkStandardNewMacro(BoneProp);

namespace {

using Entries = std::bitset<512>;  // of the palette

constexpr double kPoresFrom_mm = 0.5;  // pores are too small to be seen if a pixel is as large as this

// The vertex's entry in the palette: as in shaders/bone.vert.
std::size_t EntryOf(const ChunkVertex& v) {
  return v.region + (v.cut > 127 ? 256u : 0u);
}

// One chunk at one step.
struct Uploaded {
  ChunkBuffers::Place place;
  std::uint32_t corners = 0;
  std::uint32_t skirt = 0;  // number of skirt indices, stored after the others
  Entries entries;          // those of its vertices
};

// Cut chunks are drawn at one of the last two steps.
constexpr std::size_t kFirstCutStep = BoneChunks::kSteps.size() - 2;
constexpr double kCutCell_points = 1.6;

struct Chunk {
  std::array<Uploaded, BoneChunks::kSteps.size()> steps;
  std::array<bool, BoneChunks::kSteps.size()> known{};
  bool cut = false;
  Box3 box;
  // Cone around this axis that contains all normals of all steps. A chunk that faces entirely away is not drawn.
  Vec3 axis{0};
  double cos_cone = -1;
  bool has_cone = false;

  void IncludeNormals(const ChunkMesh& mesh) {
    if (mesh.vertices.empty()) return;
    const auto normal = [](const ChunkVertex& v) { return Vec3{v.normal[0], v.normal[1], v.normal[2]} / 127.0; };
    if (cut || mesh.cut) {
      cos_cone = -1;
      has_cone = true;
      return;
    }
    if (!has_cone) {
      Vec3 sum{0};
      for (const ChunkVertex& v : mesh.vertices) sum += normal(v);
      axis = CalcDirection(sum).value_or(Vec3{0, 0, 1});
      cos_cone = 1;
      has_cone = true;
    }
    for (const ChunkVertex& v : mesh.vertices) cos_cone = std::min(cos_cone, glm::dot(axis, normal(v)));
  }
  // `eye_W`: viewpoint in perspective. In parallel projection the lines of sight run along -toward_eye_W.
  bool FacesAway(const Vec3& eye_W, const Vec3& toward_eye_W, bool parallel) const {
    if (cos_cone <= 0.1) return false;
    Vec3 to_eye = toward_eye_W;
    double spread = 0;  // of the lines of sight over the chunk, as a sine
    if (!parallel) {
      const Vec3 d = eye_W - box.centre();
      const double far = glm::length(d);
      const double radius = 0.5 * glm::length(box.size());
      if (far <= 2 * radius) return false;
      to_eye = d / far;
      spread = radius / far;
    }
    // The triangle normals deviate slightly from the vertex normals.
    constexpr double kSlack = 0.12;
    return glm::dot(axis, to_eye) < -std::sqrt(1 - cos_cone * cos_cone) - spread - kSlack;
  }
};

// The six planes of the view frustum. A box entirely outside one of them is not drawn.
class Frustum {
 public:
  explicit Frustum(const double (&m)[16]) {  // rows of clip from world
    for (int i = 0; i < 6; ++i) {
      const int row = i / 2;
      const double sign = i % 2 == 0 ? 1 : -1;
      for (int k = 0; k < 4; ++k) sides_[i][k] = m[12 + k] + sign * m[4 * row + k];
    }
  }
  bool Intersects(const Box3& box) const {
    for (const auto& s : sides_) {
      const Vec3 farthest{s[0] > 0 ? box.upper.x : box.lower.x, s[1] > 0 ? box.upper.y : box.lower.y,
                          s[2] > 0 ? box.upper.z : box.lower.z};
      if (s[0] * farthest.x + s[1] * farthest.y + s[2] * farthest.z + s[3] < 0) return false;
    }
    return true;
  }

 private:
  double sides_[6][4];
};

std::size_t PlaceOf(int step) {
  for (std::size_t i = 0; i < BoneChunks::kSteps.size(); ++i) {
    if (BoneChunks::kSteps[i] == step) return i;
  }
  return 0;
}

}  // namespace

struct BoneProp::State {
  GlProgram plain, with_pores;
  GLuint palette = 0;
  Entries porous;
  std::array<float, 4 * 512> colours{};
  bool colours_changed = true;
  Vec3 origin_W{0};
  double reach_mm = 1;
  double unit_mm() const { return reach_mm / 32767; }  // of the vertices' positions
  std::map<std::array<int, 3>, Chunk> chunks;
  std::array<ChunkBuffers, BoneChunks::kSteps.size()> buffers;  // of each step
  Box3 box;
  double bounds[6] = {0, 0, 0, 0, 0, 0};
  bool translucent = false;
  bool hidden = false;
  double pixel_mm = 0.1;
  double voxel_mm = 0.1;
  double scale = 1;
  Fineness fineness;
  Counts counts;

  void MakePrograms() {
    const auto insert = [](const std::string& code, std::string text) {
      return text.insert(text.find('\n') + 1, code);  // after the version
    };
    const std::string vertex = insert(MakeLampCode(), shaders::kBoneVert), pores = "#define PORES\n";
    plain.Make("bone", vertex.c_str(), shaders::kBoneFrag);
    with_pores.Make("bone", insert(pores, vertex).c_str(), insert(pores, shaders::kBoneFrag).c_str());
    for (const GlProgram* program : {&plain, &with_pores}) {
      glUniformBlockBinding(program->id(), glGetUniformBlockIndex(program->id(), "Palette"), 0);
    }
    glGenBuffers(1, &palette);
  }
  // Returns the coarsest step, from index `first` on, whose cells are at most `cell_px` points wide.
  std::size_t StepFor(double cell_px, std::size_t first) const {
    std::size_t i = first;
    while (i + 1 < BoneChunks::kSteps.size() && BoneChunks::kSteps[i] * voxel_mm > cell_px * scale * pixel_mm) ++i;
    return i;
  }
  // Chooses the step by cell size, or a coarser one if there would be too many triangles. `seen`: the chunks in view.
  std::size_t ChooseStep(const std::vector<std::pair<std::array<int, 3>, const Chunk*>>& seen) const {
    std::size_t step = StepFor(fineness.cell_points, 0);
    const std::size_t coarsest = StepFor(fineness.coarsest_cell_points, 0);
    for (; step > coarsest; --step) {
      std::size_t corners = 0;
      for (const auto& [index, chunk] : seen) {
        const Uploaded* uploaded = Choose(*chunk, step);
        if (uploaded != nullptr) corners += static_cast<std::size_t>(uploaded->corners);
      }
      if (corners <= 3 * fineness.triangles) break;
    }
    return step;
  }

  const Uploaded* Choose(const Chunk& chunk, std::size_t wanted) const {
    // A kerf is narrower than a coarse cell.
    const std::size_t preferred = chunk.cut ? std::max(wanted, StepFor(kCutCell_points, kFirstCutStep)) : wanted;
    for (std::size_t i = preferred; i < chunk.steps.size(); ++i) {
      if (chunk.known[i] && !(i > preferred && chunk.known[preferred])) return &chunk.steps[i];
    }
    for (std::size_t i = preferred; i-- > 0;) {
      if (chunk.known[i]) return &chunk.steps[i];
    }
    return nullptr;
  }
};

BoneProp::BoneProp() : state_(std::make_unique<State>()) {}
BoneProp::~BoneProp() = default;

void BoneProp::Begin(const Vec3& origin_W, double reach_mm) {
  state_->chunks.clear();
  state_->origin_W = origin_W;
  state_->reach_mm = reach_mm;
  for (ChunkBuffers& buffers : state_->buffers) {
    buffers.Clear();
    buffers.set_unit_mm(state_->unit_mm());
  }
  state_->box = {};
  state_->counts = {};
}

void BoneProp::SetChunk(const ChunkMesh& mesh) {
  const std::size_t place = PlaceOf(mesh.step);
  Chunk& chunk = state_->chunks[mesh.index];
  Uploaded& uploaded = chunk.steps[place];
  state_->buffers[place].Put(mesh, uploaded.place);
  uploaded.corners = static_cast<std::uint32_t>(mesh.triangles.size());
  uploaded.skirt = static_cast<std::uint32_t>(mesh.skirt.size());
  uploaded.entries.reset();
  for (const ChunkVertex& v : mesh.vertices) uploaded.entries.set(EntryOf(v));
  // The other steps are out of date; new meshes of the needed steps follow.
  if (mesh.cut && mesh.step == 1) chunk.known = {};
  chunk.known[place] = true;
  chunk.IncludeNormals(mesh);
  chunk.cut = chunk.cut || mesh.cut;
  if (!mesh.vertices.empty()) {
    for (const Vec3& p : {mesh.lower_W, mesh.upper_W}) {
      chunk.box.Include(p);
      state_->box.Include(p);
    }
  }
  state_->counts.chunks = state_->chunks.size();
}

void BoneProp::SetPalette(const std::array<std::array<std::uint8_t, 4>, 512>& palette) {
  for (std::size_t i = 0; i < palette.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) state_->colours[4 * i + k] = static_cast<float>(palette[i][k]) / 255.0F;
    state_->porous.set(i, palette[i][3] > 0);
  }
  state_->colours_changed = true;
}

void BoneProp::SetTranslucent(bool translucent) {
  state_->translucent = translucent;
}

void BoneProp::SetHidden(bool hidden) {
  state_->hidden = hidden;
}

void BoneProp::SetPixel(double pixel_mm, double scale, double voxel_mm) {
  state_->pixel_mm = pixel_mm;
  state_->scale = scale;
  state_->voxel_mm = voxel_mm;
}

void BoneProp::SetFineness(const Fineness& fineness) {
  state_->fineness = fineness;
}

const BoneProp::Counts& BoneProp::counts() const {
  return state_->counts;
}

std::vector<Vec3> BoneProp::ListCorners() const {
  std::vector<Vec3> corners;
  for (const auto& [index, chunk] : state_->chunks) {
    if (chunk.box.empty()) continue;
    for (int i = 0; i < 8; ++i) {
      corners.emplace_back((i & 1) != 0 ? chunk.box.upper.x : chunk.box.lower.x,
                           (i & 2) != 0 ? chunk.box.upper.y : chunk.box.lower.y,
                           (i & 4) != 0 ? chunk.box.upper.z : chunk.box.lower.z);
    }
  }
  return corners;
}

int BoneProp::RenderOpaqueGeometry(vtkViewport* viewport) {
  State& s = *state_;
  s.counts.drawn = 0;
  s.counts.triangles = 0;
  s.counts.bytes = 0;
  for (const ChunkBuffers& buffers : s.buffers) s.counts.bytes += buffers.CountBytes();
  auto* renderer = vtkOpenGLRenderer::SafeDownCast(viewport);
  if (renderer == nullptr || s.chunks.empty() || s.hidden) return 0;
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  if (window == nullptr) return 0;
  vtkOpenGLState& state = *window->GetState();
  window->GetShaderCache()->ReleaseCurrentShader();
  if (s.palette == 0) s.MakePrograms();
  glBindBuffer(GL_UNIFORM_BUFFER, s.palette);
  if (s.colours_changed) {
    glBufferData(GL_UNIFORM_BUFFER, sizeof(s.colours), s.colours.data(), GL_STATIC_DRAW);
    s.colours_changed = false;
  }
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, s.palette);

  vtkCamera& camera = *renderer->GetActiveCamera();
  double view[16];
  vtkMatrix4x4::DeepCopy(view, camera.GetViewTransformMatrix());
  double clip[16];
  vtkMatrix4x4::DeepCopy(clip, camera.GetProjectionTransformMatrix(renderer->GetTiledAspectRatio(), -1, 1));
  double both[16];
  vtkMatrix4x4::Multiply4x4(clip, view, both);
  const Frustum frustum(both);
  // Vertices are relative to the bone's origin, where single precision is sufficient.
  for (int i = 0; i < 3; ++i) {
    view[4 * i + 3] += view[4 * i] * s.origin_W.x + view[4 * i + 1] * s.origin_W.y + view[4 * i + 2] * s.origin_W.z;
  }
  const Entries porous = s.pixel_mm < kPoresFrom_mm ? s.porous : Entries();
  for (const GlProgram* program : {&s.plain, &s.with_pores}) {
    program->Use();
    glUniformMatrix4fv(program->Uniform("view_from_bone"), 1, GL_FALSE, ToGl(view).data());
    glUniformMatrix4fv(program->Uniform("clip_from_view"), 1, GL_FALSE, ToGl(clip).data());
    glUniform3f(program->Uniform("to_eye"), 0, 0, 1);
    glUniform1f(program->Uniform("parallel"), camera.GetParallelProjection() != 0 ? 1.0F : 0.0F);
    glUniform1f(program->Uniform("opacity"), s.translucent ? 0.16F : 1.0F);
    glUniform1f(program->Uniform("pixel_mm"), static_cast<float>(s.pixel_mm));
    glUniform1f(program->Uniform("unit_mm"), static_cast<float>(s.unit_mm()));
  }

  // Draws front to back, so that hidden fragments are not shaded.
  double eye[3];
  double toward[3];
  camera.GetPosition(eye);
  camera.GetDirectionOfProjection(toward);
  const Vec3 eye_W{eye[0], eye[1], eye[2]};
  const Vec3 toward_eye_W{-toward[0], -toward[1], -toward[2]};
  std::vector<std::pair<std::array<int, 3>, const Chunk*>> in_view;
  for (const auto& [index, chunk] : s.chunks) {
    if (chunk.box.empty() || !frustum.Intersects(chunk.box)) continue;
    if (!s.translucent && chunk.FacesAway(eye_W, toward_eye_W, camera.GetParallelProjection() != 0)) continue;
    in_view.emplace_back(index, &chunk);
  }
  const std::size_t step = s.ChooseStep(in_view);
  s.counts.step = BoneChunks::kSteps[step];
  // Coarser chunks below a finer one need their skirts.
  std::set<std::array<int, 3>> skirted;
  for (const auto& [index, chunk] : in_view) {
    const Uploaded* uploaded = s.Choose(*chunk, step);
    if (uploaded == nullptr || uploaded == &chunk->steps[step]) continue;
    for (int i = 1; i < 8; ++i) skirted.insert({index[0] - (i & 1), index[1] - ((i >> 1) & 1), index[2] - (i >> 2)});
  }
  // Chunks that are drawn in one call follow each other: those of the same step and the same program.
  struct ToDraw {
    double depth;
    const Uploaded* uploaded;
    std::uint32_t corners;
    std::size_t step;
    bool porous;
    bool operator<(const ToDraw& other) const { return depth < other.depth; }
  };
  std::vector<ToDraw> seen;
  for (const auto& [index, chunk] : in_view) {
    const Uploaded* uploaded = s.Choose(*chunk, step);
    if (uploaded == nullptr) continue;
    // In a translucent bone an overlap is more visible than a narrow gap.
    const bool skirt = !s.translucent && skirted.count(index) != 0;
    const std::uint32_t corners = uploaded->corners + (skirt ? uploaded->skirt : 0);
    if (corners == 0) continue;
    seen.push_back(ToDraw{-glm::dot(chunk->box.centre(), toward_eye_W), uploaded, corners,
                          static_cast<std::size_t>(uploaded - chunk->steps.data()),
                          (uploaded->entries & porous).any()});
    ++s.counts.drawn;
    s.counts.triangles += corners / 3;
  }
  std::sort(seen.begin(), seen.end());
  std::vector<ChunkBuffers::ToDraw> together;
  const auto draw_all = [&] {
    const GlProgram* used = nullptr;
    for (std::size_t i = 0; i < seen.size();) {
      const ToDraw& first = seen[i];
      together.clear();
      for (; i < seen.size() && seen[i].step == first.step && seen[i].porous == first.porous; ++i) {
        together.push_back({&seen[i].uploaded->place, seen[i].corners});
      }
      const GlProgram& program = first.porous ? s.with_pores : s.plain;
      if (&program != used) program.Use();
      used = &program;
      s.buffers[first.step].Draw(together);
    }
  };
  state.vtkglEnable(GL_DEPTH_TEST);
  if (s.translucent) {
    // Far sides are drawn first; with depth writes off, neither side hides the structures inside.
    state.vtkglEnable(GL_BLEND);
    state.vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    state.vtkglDepthMask(GL_FALSE);
    state.vtkglEnable(GL_CULL_FACE);
    state.vtkglCullFace(GL_FRONT);
    draw_all();
    state.vtkglCullFace(GL_BACK);
    draw_all();
    state.vtkglDisable(GL_CULL_FACE);
    state.vtkglDepthMask(GL_TRUE);
  } else {
    state.vtkglDisable(GL_BLEND);
    state.vtkglDepthMask(GL_TRUE);
    // The back of a closed surface is never visible.
    state.vtkglEnable(GL_CULL_FACE);
    state.vtkglCullFace(GL_BACK);
    draw_all();
    state.vtkglDisable(GL_CULL_FACE);
    state.vtkglEnable(GL_BLEND);
  }
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glUseProgram(0);
  return 1;
}

double* BoneProp::GetBounds() {
  if (state_->box.empty()) return nullptr;
  for (int i = 0; i < 3; ++i) {
    state_->bounds[2 * i] = state_->box.lower[i];
    state_->bounds[2 * i + 1] = state_->box.upper[i];
  }
  return state_->bounds;
}

void BoneProp::ReleaseGraphicsResources(vtkWindow* window) {
  Begin(state_->origin_W, state_->reach_mm);
  if (state_->palette != 0) glDeleteBuffers(1, &state_->palette);
  state_->palette = 0;
  state_->colours_changed = true;
  state_->plain.Release();
  state_->with_pores.Release();
  Superclass::ReleaseGraphicsResources(window);
}

}  // namespace kerf
