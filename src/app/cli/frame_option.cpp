#include "app/cli/frame_option.h"

#include "bone/import/patient_frame.h"
#include "kerf/error.h"

namespace kerf::cli {

CLI::Option* AddFrameOption(CLI::App& command, std::string& frame) {
  return command
      .add_option("--frame", frame,
                  "Directions of the file's x, y and z axes in the patient, instead of those in its header: three "
                  "letters, such as LPS (left, posterior, superior) or RAS")
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
