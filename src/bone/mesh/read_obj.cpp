#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "bone/mesh/read.h"
#include "bone/mesh/words.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// A face may have any number of corners, so the number of triangles is also checked each time this many have been
/// added.
constexpr int kCheckInterval = 1 << 20;

template <typename Number>
bool ParseWord(std::string_view word, Number& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

TriangleMesh ReadObj(std::string_view bytes, const std::string& path) {
  TriangleMesh mesh;
  std::size_t line_number = 0;
  const auto fail = [&](const std::string& what) -> Error {
    return Error(fmt::format("{}:{}: {}", path, line_number, what));
  };
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    const std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    ++line_number;
    Words words(line);
    const std::string_view keyword = words.Next();
    if (keyword == "v") {
      Vec3 p{0};
      for (int i = 0; i < 3; ++i) {
        const std::string_view word = words.Next();
        if (word.empty()) throw fail(fmt::format("expected three numbers after 'v', but found only {}", i));
        if (!ParseWord(word, p[i])) throw fail(fmt::format("expected three numbers after 'v', but found '{}'", word));
      }
      mesh.points.push_back(p);
    } else if (keyword == "f") {
      // A polygon becomes a fan of triangles. Indices count from 1, or backwards from the last point if negative.
      std::uint32_t first = 0;
      std::uint32_t previous = 0;
      int corners = 0;
      for (std::string_view word = words.Next(); !word.empty(); word = words.Next()) {
        std::int64_t index = 0;
        const auto count = static_cast<std::int64_t>(mesh.points.size());
        if (!ParseWord(word.substr(0, word.find('/')), index)) {
          throw fail(fmt::format("expected point numbers after 'f', but found '{}'", word));
        }
        if (index < 0) index += count + 1;
        if (index < 1 || index > count) {
          throw fail(
              fmt::format("a face uses point {}, but the number of points defined before it is {}; they count from 1",
                          word.substr(0, word.find('/')), count));
        }
        const auto id = static_cast<std::uint32_t>(index - 1);
        if (corners % kCheckInterval == 0) CheckTriangles(mesh.triangles.size(), path);
        if (corners >= 2) mesh.triangles.push_back({first, previous, id});
        if (corners == 0) first = id;
        previous = id;
        ++corners;
      }
      CheckTriangles(mesh.triangles.size(), path);
      if (corners < 3) throw fail("a face needs at least three points");
    }
    // Everything else (normals, textures, groups, materials, comments) does not affect the shape.
  }
  return mesh;
}

}  // namespace kerf
