// A CT drawn for its coordinates to be read off: what `kerf import --keep` and `--drop` ask for.
#pragma once

#include <string>
#include <vector>

#include "bone/import/import.h"

namespace kerf::cli {

struct CtSheetOptions {
  std::string input;
  std::string output;
  std::string title;  // empty: the input's name
  int width = 2400;   // pixels
  int height = 1800;
  std::vector<std::string> slices;      // "z=373.5"; empty: those of the points, else spread over the bone
  std::vector<std::string> keep, drop;  // points x,y,z to be marked
  ImportOptions import;                 // of which the series and the iso value count
};

void DrawCtSheet(const CtSheetOptions& options);

}  // namespace kerf::cli
