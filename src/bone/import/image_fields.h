// The text header of an NRRD or MetaImage file.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace kerf {

struct ImageFields {
  std::map<std::string, std::string> values;  // by name, in lower case and without blanks
  std::size_t end = 0;                        // bytes up to the data, when they follow in the same file
  bool complete = false;                      // NRRD: the empty line; MetaImage: ElementDataFile

  bool Contains(const std::string& name) const { return values.count(name) != 0; }
  std::string Get(const std::string& name) const;  // "" when absent
};

/// At most the first kMaxImageHeaderBytes of a file. Throws Error.
std::string ReadHead(const std::string& path);
ImageFields ParseNrrdFields(const std::string& head);
ImageFields ParseMetaFields(const std::string& head);

std::string Lower(std::string text);
bool EndsWith(const std::string& text, const std::string& end);
/// Numbers separated by blanks, up to the first word that is none.
std::vector<double> ParseNumbers(const std::string& text);

}  // namespace kerf
