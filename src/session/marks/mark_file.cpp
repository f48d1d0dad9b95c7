#include "session/marks/mark_file.h"

#include <fmt/format.h>

#include "base/files/files.h"
#include "base/files/limits.h"
#include "base/files/markups.h"
#include "kerf/error.h"

namespace kerf {
namespace {

MarkKind GuessKind(const std::string& name) {
  for (std::size_t i = 0; i < kMarkKindWords.size(); ++i) {
    if (name.starts_with(kMarkKindWords[i])) return static_cast<MarkKind>(i);
  }
  return MarkKind::kOther;
}

}  // namespace

std::vector<Mark> ParseMarks(const std::string& text, const std::string& path) {
  std::vector<Mark> marks;
  for (const TubeMarkup& markup : ParseTubeMarkups(text, path)) {
    Mark mark{.name = markup.name, .kind = GuessKind(markup.name), .points_W = markup.points};
    if (markup.radius_mm) mark.radius_mm = *markup.radius_mm;
    if (!markup.kind.empty()) {
      const std::optional<MarkKind> kind = MarkKindFromString(markup.kind);
      if (!kind) {
        throw Error(fmt::format("{}: 'kind' of the curve '{}' is '{}'; it must be nerve, canal, tooth, root or other",
                                path, markup.name.substr(0, 60), markup.kind.substr(0, 60)));
      }
      mark.kind = *kind;
    }
    marks.push_back(std::move(mark));
  }
  try {
    CheckMarks(marks);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path, e.what()));
  }
  return marks;
}

std::vector<Mark> ReadMarks(const std::string& path) {
  return ParseMarks(ReadTextFile(path, kMaxMarkupBytes), path);
}

std::string FormatMarks(const std::vector<Mark>& marks) {
  std::vector<TubeMarkup> markups;
  for (const Mark& mark : marks) {
    if (mark.points_W.empty()) continue;
    markups.push_back({.name = mark.name,
                       .points = mark.points_W,
                       .radius_mm = mark.radius_mm,
                       .kind = std::string(ToString(mark.kind))});
  }
  return FormatTubeMarkups(markups);
}

void WriteMarks(const std::string& path, const std::vector<Mark>& marks) {
  WriteTextFile(path, FormatMarks(marks));
}

}  // namespace kerf
