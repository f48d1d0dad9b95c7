#include "app/window/import_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "view/ui/translate.h"

namespace kerf {

std::string GetNote(const Bone& bone, const std::string& key) {
  const auto found = bone.notes().find(key);
  return found == bone.notes().end() ? std::string() : found->second;
}

bool IsFromCt(const Bone& bone) {
  const std::string input = GetNote(bone, "import_input");
  return input == "DICOM" || input == "image";
}

std::string DescribeImport(const Bone& bone, const std::function<std::string(const std::string&)>& translate) {
  const std::string notes = GetNote(bone, "import_warnings");  // sentences without capitals, separated by ". "
  std::string text;
  for (std::size_t at = 0; at < notes.size();) {
    const std::size_t end = std::min(notes.find(". ", at), notes.size());
    std::string sentence = translate(notes.substr(at, end - at));
    if (!sentence.empty()) sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
    text += (text.empty() ? "" : "\n") + sentence + ".";
    at = end + 2;
  }
  return text;
}

std::string DescribeSurfaceError(const Bone& bone, const std::function<std::string(const std::string&)>& translate) {
  const std::string note = GetNote(bone, kSurfaceErrorNote);
  double expected_mm = 0, offset_mm = 0, scatter_mm = 0;
  if (std::sscanf(note.c_str(), "%lf expected (rms): offset %lf, scatter %lf", &expected_mm, &offset_mm, &scatter_mm) !=
      3) {
    return note.empty() ? note : translate(note);
  }
  const char* const text =
      offset_mm < 0 ? Msg("about {:.2f} mm: on average it lies {:.2f} mm too far inside, and it varies by {:.2f} mm")
                    : Msg("about {:.2f} mm: on average it lies {:.2f} mm too far outside, and it varies by {:.2f} mm");
  return translate(fmt::format(fmt::runtime(text), expected_mm, std::abs(offset_mm), scatter_mm));
}

}  // namespace kerf
