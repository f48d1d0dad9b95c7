#include "app/cli/ct_options.h"

#include "app/cli/numbers.h"
#include "bone/import/patient_frame.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

std::string CheckFrame(const std::string& letters) {
  try {
    LpsFromFrame(letters);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace

void AddCtOptions(CLI::App& command, ImportOptions& import, const std::string& group) {
  command
      .add_option("--series", import.series,
                  "UID of the DICOM series as 'kerf import --list' prints it, or its end; default: the CT that suits a "
                  "jaw, if one clearly does")
      ->group(group);
  command
      .add_flag("--as-ct", import.as_ct,
                "Read a DICOM series that is not stated to be a CT, such as modality OT or secondary captures, as one")
      ->group(group);
  command
      .add_option("--frame", import.frame,
                  "Directions of the file's x, y and z axes in the patient, instead of those in its header: three "
                  "letters, such as LPS (left, posterior, superior) or RAS")
      ->check(CheckFrame)
      ->group(group);
  AddNumber(command, "--spacing-z", import, "spacing_z_mm")->group(group);
}

void RejectCtOptions(const CLI::App& command, const std::string& why) {
  for (const char* option : {"--series", "--as-ct", "--frame", "--spacing-z"}) {
    if (command.count(option) > 0) throw CLI::ValidationError(option, why);
  }
}

}  // namespace kerf::cli
