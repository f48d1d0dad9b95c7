// Text header of an NRRD or MetaImage file.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace kerf {

struct ImageFields {
  std::map<std::string, std::string> values;  // by name, in lower case and without blanks
  std::map<std::string, std::string> keys;    // NRRD: the lines "key:=value", as they are
  std::size_t end = 0;                        // number of bytes before the data, if they follow in the same file
  bool complete = false;                      // true if the end was found; NRRD: the empty line; MetaImage:
                                              // ElementDataFile

  bool Contains(const std::string& name) const { return values.count(name) != 0; }
  std::string Get(const std::string& name) const;  // "" if absent
};

/// Reads at most the first kMaxImageHeaderBytes of a file. Throws kerf::Error if it cannot be read.
std::string ReadHead(const std::string& path);
ImageFields ParseNrrdFields(const std::string& head);
ImageFields ParseMetaFields(const std::string& head);

std::string Lower(std::string text);
bool EndsWith(const std::string& text, const std::string& end);
/// Parses numbers separated by blanks, up to the first word that is not a number.
std::vector<double> ParseNumbers(const std::string& text);

}  // namespace kerf
