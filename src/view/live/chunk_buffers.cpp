#define GL_GLEXT_PROTOTYPES
#include "view/live/chunk_buffers.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "view/live/free_ranges.h"

namespace kerf {
namespace {

// Of a page: 3.1 MB of vertices and, as a vertex of a closed surface has six corners of triangles, 3.7 MB of indices.
constexpr std::uint32_t kVertices = 1U << 18;
constexpr std::uint32_t kIndices = 7 * kVertices;

struct StoredVertex {
  std::array<std::int16_t, 3> position;  // in units
  std::array<std::int8_t, 3> normal;
  std::uint8_t region;
  std::uint8_t cut;
  std::uint8_t unused;
};
static_assert(sizeof(StoredVertex) == 12);

std::size_t SizeOf(bool wide) {
  return wide ? sizeof(std::uint32_t) : sizeof(std::uint16_t);
}

const void* Offset(std::size_t bytes) {
  return static_cast<const char*>(nullptr) + bytes;
}

// Stores indices in the width of a page.
template <typename Index>
void StoreIndices(const ChunkMesh& mesh, std::uint32_t first) {
  thread_local std::vector<Index> indices;
  indices.assign(mesh.triangles.begin(), mesh.triangles.end());
  indices.insert(indices.end(), mesh.skirt.begin(), mesh.skirt.end());
  glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLintptr>(first * sizeof(Index)),
                  static_cast<GLsizeiptr>(indices.size() * sizeof(Index)), indices.data());
}

}  // namespace

struct ChunkBuffers::Page {
  // `is_wide`: with indices of 32 bits.
  Page(std::uint32_t vertex_count, std::uint32_t index_count, bool is_wide)
      : free_vertices(vertex_count),
        free_indices(index_count),
        wide(is_wide),
        bytes(vertex_count * sizeof(StoredVertex) + index_count * SizeOf(wide)) {
    glGenVertexArrays(1, &vertex_array);
    glGenBuffers(1, &vertices);
    glGenBuffers(1, &indices);
    glBindVertexArray(vertex_array);
    glBindBuffer(GL_ARRAY_BUFFER, vertices);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertex_count * sizeof(StoredVertex)), nullptr,
                 GL_DYNAMIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_count * SizeOf(wide)), nullptr,
                 GL_DYNAMIC_DRAW);
    constexpr GLsizei kStride = sizeof(StoredVertex);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_SHORT, GL_FALSE, kStride, Offset(offsetof(StoredVertex, position)));
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 3, GL_BYTE, GL_TRUE, kStride, Offset(offsetof(StoredVertex, normal)));
    glEnableVertexAttribArray(2);
    glVertexAttribIPointer(2, 2, GL_UNSIGNED_BYTE, kStride, Offset(offsetof(StoredVertex, region)));
    glBindVertexArray(0);
  }
  ~Page() {
    glDeleteVertexArrays(1, &vertex_array);
    glDeleteBuffers(1, &vertices);
    glDeleteBuffers(1, &indices);
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  GLuint vertex_array = 0;
  GLuint vertices = 0;
  GLuint indices = 0;
  FreeRanges free_vertices, free_indices;
  const bool wide;
  const std::size_t bytes;
};

ChunkBuffers::ChunkBuffers() = default;
ChunkBuffers::~ChunkBuffers() = default;

int ChunkBuffers::FindPage(std::uint32_t vertices, std::uint32_t indices, Place& place) {
  const bool wide = vertices > 0xffff;
  const auto fits = [&](Page& page) {
    if (page.wide != wide) return false;
    const std::optional<std::uint32_t> vertex = page.free_vertices.Take(vertices);
    if (!vertex) return false;
    const std::optional<std::uint32_t> index = page.free_indices.Take(indices);
    if (!index) {
      page.free_vertices.Give(*vertex, vertices);
      return false;
    }
    place.first_vertex = *vertex;
    place.first_index = *index;
    return true;
  };
  for (std::size_t i = 0;; ++i) {
    if (i == pages_.size()) {
      pages_.push_back(std::make_unique<Page>(std::max(kVertices, vertices), std::max(kIndices, indices), wide));
    }
    if (fits(*pages_[i])) return static_cast<int>(i);
  }
}

void ChunkBuffers::Put(const ChunkMesh& mesh, Place& place) {
  Remove(place);
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto indices = static_cast<std::uint32_t>(mesh.triangles.size() + mesh.skirt.size());
  if (vertices == 0 || indices == 0) return;
  place.page = FindPage(vertices, indices, place);
  place.vertices = vertices;
  place.indices = indices;
  thread_local std::vector<StoredVertex> stored;
  stored.clear();
  const double per_mm = 1 / unit_mm_;
  for (const ChunkVertex& v : mesh.vertices) {
    StoredVertex& to = stored.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      using Limits = std::numeric_limits<std::int16_t>;
      to.position[i] = static_cast<std::int16_t>(
          std::clamp<double>(std::nearbyint(per_mm * double{v.p_mm[i]}), Limits::min(), Limits::max()));
    }
    to.normal = v.normal;
    to.region = v.region;
    to.cut = v.cut;
    to.unused = 0;
  }
  const Page& page = *pages_[static_cast<std::size_t>(place.page)];
  glBindVertexArray(0);  // binding indices would change a bound vertex array
  glBindBuffer(GL_ARRAY_BUFFER, page.vertices);
  glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(place.first_vertex * sizeof(StoredVertex)),
                  static_cast<GLsizeiptr>(stored.size() * sizeof(StoredVertex)), stored.data());
  glBindVertexArray(page.vertex_array);
  if (page.wide) {
    StoreIndices<std::uint32_t>(mesh, place.first_index);
  } else {
    StoreIndices<std::uint16_t>(mesh, place.first_index);
  }
  glBindVertexArray(0);
}

void ChunkBuffers::Remove(Place& place) {
  if (place.page >= 0) {
    Page& page = *pages_[static_cast<std::size_t>(place.page)];
    page.free_vertices.Give(place.first_vertex, place.vertices);
    page.free_indices.Give(place.first_index, place.indices);
  }
  place = {};
}

void ChunkBuffers::Clear() {
  pages_.clear();
}

std::size_t ChunkBuffers::CountBytes() const {
  std::size_t bytes = 0;
  for (const std::unique_ptr<Page>& page : pages_) bytes += page->bytes;
  return bytes;
}

void ChunkBuffers::Draw(std::span<const ToDraw> meshes) {
  for (std::size_t i = 0; i < meshes.size();) {
    const int number = meshes[i].place->page;
    const Page& page = *pages_[static_cast<std::size_t>(number)];
    counts_.clear();
    offsets_.clear();
    first_vertices_.clear();
    for (; i < meshes.size() && meshes[i].place->page == number; ++i) {
      counts_.push_back(static_cast<GLsizei>(meshes[i].corners));
      offsets_.push_back(Offset(meshes[i].place->first_index * SizeOf(page.wide)));
      first_vertices_.push_back(static_cast<GLint>(meshes[i].place->first_vertex));
    }
    glBindVertexArray(page.vertex_array);
    glMultiDrawElementsBaseVertex(GL_TRIANGLES, counts_.data(), page.wide ? GL_UNSIGNED_INT : GL_UNSIGNED_SHORT,
                                  offsets_.data(), static_cast<GLsizei>(counts_.size()), first_vertices_.data());
  }
  glBindVertexArray(0);
}

}  // namespace kerf
