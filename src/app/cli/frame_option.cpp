#include "app/cli/frame_option.h"

#include "bone/import/patient_frame.h"
#include "kerf/error.h"

namespace kerf::cli {

CLI::Option* AddFrameOption(CLI::App& command, std::string& frame) {
  return command
      .add_option("--frame", frame,
                  "Where x, y and z of the file's coordinates point to in the patient, whatever its header says: three "
                  "letters, as LPS (left, posterior, superior) or RAS.")
      ->check([](const std::string& letters) {
        try {
          LpsFromFrame(letters);
        } catch (const Error& e) {
          return std::string(e.what());
        }
        return std::string();
      });
}

}  // namespace kerf::cli
