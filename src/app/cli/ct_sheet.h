// Sheet of CT slices with coordinate axes, for finding the coordinates that `kerf import --keep` and `--drop` need.
#pragma once

#include <string>
#include <vector>

#include "bone/import/import.h"

namespace kerf::cli {

struct CtSheetOptions {
  std::string input;
  std::string output;
  std::string title;  // empty: the name of the input
  int width = 2400;   // pixels
  int height = 1800;
  std::vector<std::string> slices;      // "z=373.5"; empty: through the points or, without any, spread over the bone
  std::vector<std::string> keep, drop;  // points x,y,z to mark
  ImportOptions import;                 // only the series, the frame, the iso value and the mask are used
};

void DrawCtSheet(const CtSheetOptions& options);

}  // namespace kerf::cli
