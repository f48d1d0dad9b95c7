#include "app/window/import_notes.h"

#include <algorithm>
#include <cctype>

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
    text += (text.empty() ? "" : " ") + sentence + ".";
    at = end + 2;
  }
  return text;
}

}  // namespace kerf
