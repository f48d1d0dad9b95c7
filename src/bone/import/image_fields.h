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
  std::vector<std::string> files;             // lines after a data file of "LIST": one file each
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

/// Lists the files of an image whose voxels are in several files, as the header's value `data_file` and the lines
/// `files` after it name them: "LIST" with an optional number of dimensions, or a pattern with one number as in
/// "slice_%03d.raw" and its first, last and step. `sizes`: of the image; the files have equal parts of it, in order.
/// Returns nothing if `data_file` names one file. Throws kerf::Error, with `path` in the message, if the number of
/// files does not fit the sizes or is above kMaxDataFiles.
std::vector<std::string> ListDataFiles(const std::string& data_file, const std::vector<std::string>& files,
                                       const std::vector<double>& sizes, const std::string& path);

std::string Lower(std::string text);
bool EndsWith(const std::string& text, const std::string& end);
/// Parses numbers separated by blanks, up to the first word that is not a number.
std::vector<double> ParseNumbers(const std::string& text);

}  // namespace kerf
