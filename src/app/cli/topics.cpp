#include "app/cli/topics.h"

#include <algorithm>
#include <iterator>

namespace kerf::cli {
namespace {

constexpr Topic kTopics[] = {
    {"workflow", "Which command does what, from a CT to a report",
     R"(1. Make a bone: 'kerf import' from a CT or a closed surface, 'kerf model' from
   parameters. The result is a .vdb file.
2. Describe the cut in a scene: 'kerf scene --defaults' prints a commented one;
   'kerf check' validates it.
3. Cut: 'kerf run' along the path of the scene, 'kerf loop' live with a simulated
   hand or a haptic device, 'kerf rehearse' in a window with mouse and keys.
4. Look at the results: pictures and tables are written to the folder of -o;
   'kerf log' prints a recording, 'kerf replay' runs it again.
5. Judge: 'kerf score' a recording, 'kerf assess' the cut against its plan,
   'kerf compare' models, 'kerf study' accuracy against time.
6. Check the forces: 'kerf validate' compares the force laws with published
   measurements, 'kerf calibrate' fits a law to your own, and 'kerf run
   --uncertain' shows the force as a band.)"},
    {"units", "Units and frames of all inputs and outputs",
     R"(Lengths are in mm, forces in N, times in s, stresses and moduli in MPa. Every
other unit is part of the name: E_GPa, spindle_rpm, tilt_deg, tick_us.

The world frame of a bone from a CT is the patient frame LPS: x to the patient's
left, y to the back, z to the head. The tool frame has its origin at the centre
of the disc and z along the spindle. Forces are forces on the tool.)"},
    {"files", "File formats by extension",
     R"(.toml       scene, study or arm (TOML); unknown keys are errors
.vdb        bone: level set, regions and material; any OpenVDB program opens it
.kerf       recording of a run or of a session, for 'kerf replay'
.stl .obj .ply      closed surface, read and written
.nrrd .nii .hdr .img .mha .mhd .vti, a DICOM folder    CT, read
.mrk.json   points and planes of 3D Slicer, read and written
.csv .json  results for other programs; keys and columns include their unit
.png .html .md .wav pictures, reports, sound

Every file is written to a temporary file next to it, which is then renamed, so
that an existing file stays intact until the new one is complete. docs/formats.md
describes each format.

scenes/..., volumes/... and examples/... are files that come with kerf. An installed
kerf also finds them if they do not exist in the current folder: they are in
share/kerf of the installation, such as /usr/share/kerf. Its documentation, docs/...,
is in share/doc/kerf.)"},
    {"exit-codes", "Exit codes of all commands",
     R"(0   success
1   failure: one sentence on stderr gives the reason
2   invalid use: unknown command or option, value out of range
3   results were written, but the recording that was read is damaged or cut short

Commands that react to Ctrl-C, such as 'kerf loop', end with one of these codes.
Ctrl-C ends any other command by its signal, which a shell reports as code 130.

Results go to stdout or to the file of -o, messages to stderr.)"},
    {"environment", "Environment variables that kerf reads",
     R"(DISPLAY               display of 'kerf rehearse' and 'kerf practise'
HOME                  base of the default folders below
KERF_DATA             folder of the students' history
KERF_FALCON_FIRMWARE  firmware file of a Novint Falcon
XDG_CACHE_HOME        base of the cache of generated bones, ~/.cache by default
XDG_DATA_HOME         base of the history and of session folders,
                      ~/.local/share by default
XDG_CONFIG_HOME       base of the key that signs recordings, ~/.config by default)"},
};

}  // namespace

std::span<const Topic> Topics() {
  return kTopics;
}

const Topic* FindTopic(std::string_view name) {
  const auto found =
      std::find_if(std::begin(kTopics), std::end(kTopics), [&](const Topic& t) { return name == t.name; });
  return found == std::end(kTopics) ? nullptr : found;
}

}  // namespace kerf::cli
