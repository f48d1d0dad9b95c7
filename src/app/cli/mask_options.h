// Options that name a segmentation and say what its segments are.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "bone/import/import.h"
#include "bone/segmentation/roles.h"

namespace kerf::cli {

struct MaskArguments {
  std::string file;
  LabelOptions labels;
};

/// Adds --mask, --labels, --label, --mask-threshold and --mask-reach. `what` continues the help text of --mask.
void AddMaskOptions(CLI::App& command, MaskArguments& mask, ImportOptions& import, const std::string& what,
                    const std::string& group);

/// Throws CLI::ParseError if options of a mask are given without one, or are invalid.
void CheckMaskOptions(const CLI::App& command, const MaskArguments& mask);

}  // namespace kerf::cli
