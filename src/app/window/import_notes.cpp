#include "app/window/import_notes.h"

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

std::string DescribeImport(const Bone& bone) {
  std::string text = GetNote(bone, "import_warnings");  // sentences without capitals, separated by ". "
  if (text.empty()) return text;
  bool begins = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (begins) text[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[i])));
    begins = i > 0 && text[i] == ' ' && text[i - 1] == '.';
  }
  return text + ".";
}

}  // namespace kerf
