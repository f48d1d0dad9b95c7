#include "app/cli/mask_options.h"

#include <vector>

#include "app/cli/numbers.h"
#include "bone/import/image_header.h"
#include "kerf/error.h"

namespace kerf::cli {

void AddMaskOptions(CLI::App& command, MaskArguments& mask, ImportOptions& import, const std::string& what,
                    const std::string& group) {
  command
      .add_option("--mask", mask.file,
                  "Segmentation that says which bone is the mandible (.seg.nrrd or DICOM), or label map (" +
                      ListImageExtensions() + "); " + what)
      ->group(group);
  std::vector<std::string> presets;
  for (const LabelPreset& preset : ListLabelPresets()) presets.push_back(preset.name);
  command.add_option("--labels", mask.labels.preset, "Program or data from which a mask without names comes")
      ->check(CLI::IsMember(presets))
      ->group(group);
  command
      .add_option("--label", mask.labels.assignments,
                  "What one segment of the mask is, such as 2=mandible or 'Bone 3=canal'; may be repeated")
      ->allow_extra_args(false)
      ->group(group);
  AddNumber(command, "--mask-threshold", mask.labels, "mask_threshold")->group(group);
  AddNumber(command, "--mask-reach", import, "mask_reach_mm")->group(group);
}

void CheckMaskOptions(const CLI::App& command, const MaskArguments& mask) {
  if (command.count("--mask") == 0) {
    for (const char* option : {"--labels", "--label", "--mask-threshold", "--mask-reach"}) {
      if (command.count(option) > 0) throw CLI::ValidationError(option, "applies to a mask only; name one with --mask");
    }
  }
  for (const std::string& assignment : mask.labels.assignments) {
    try {
      CheckAssignment(assignment);
    } catch (const Error& e) {
      throw CLI::ValidationError(e.what());
    }
  }
}

}  // namespace kerf::cli
