#include "app/cli/command_list.h"

#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "base/files/installed.h"
#include "session/run/bone_cache.h"

namespace kerf::cli {
namespace {

struct Group {
  const char* name;
  std::initializer_list<void (*)(CLI::App&)> commands;
};

// Groups of commands, in the order of `kerf --help`.
const Group kGroups[] = {
    {"Make a bone", {AddImportCommand, AddModelCommand}},
    {"Cut", {AddSceneCommand, AddCheckCommand, AddRunCommand, AddLoopCommand, AddReplayCommand, AddSlabCommand}},
    {"Look", {AddInfoCommand, AddPictureCommand, AddExportCommand, AddLogCommand, AddMaterialsCommand}},
    {"Practise", {AddRehearseCommand, AddPractiseCommand, AddScoreCommand, AddAssessCommand}},
    {"Measure",
     {AddCompareCommand, AddValidateCommand, AddCalibrateCommand, AddStudyCommand, AddTuneCommand, AddStabilityCommand,
      AddEffectsCommand, AddPaperCommand, AddBenchCommand}},
    {"Devices", {AddDevicesCommand, AddDeviceCommand}},
    {"Help", {AddReferenceCommand, AddCompletionCommand}},
};

struct Example {
  const char* command;
  const char* line;
};

// Each example can be run from the root of a clone and, if kerf is installed, in any folder;
// tests/app/cli/reference_test.cpp checks that every command has one.
constexpr Example kExamples[] = {
    {"import", "kerf import dicom_folder -o out/patient.vdb --voxel 0.2"},
    {"model", "kerf model block -o out/block.vdb"},
    {"model mandible", "kerf model mandible -o out/mandible.vdb --voxel 0.2"},
    {"model block", "kerf model block -o out/block.vdb --voxel 0.1"},
    {"model plate", "kerf model plate -o out/plate.vdb"},
    {"scene", "kerf scene --defaults > out/scene.toml"},
    {"check", "kerf check scenes/body_osteotomy.toml"},
    {"run", "kerf run scenes/body_osteotomy.toml -o out/body_osteotomy"},
    {"loop", "kerf loop scenes/hand_held_cut.toml --seconds 5 -o out/loop --record out/session.kerf"},
    {"replay", "kerf replay out/session.kerf --verify"},
    {"slab", "kerf slab out/mandible.vdb --plane 25,32,0,0.4,0.9,0 --thickness 0.5 -o out/slab"},
    {"info", "kerf info out/mandible.vdb"},
    {"picture", "kerf picture out/mandible.vdb -o out/mandible.png"},
    {"export", "kerf export out/mandible.vdb -o out/mandible.stl --triangles 100000"},
    {"log", "kerf log out/session.kerf --csv -o out/session.csv"},
    {"materials", "kerf materials"},
    {"rehearse", "kerf rehearse out/mandible.vdb"},
    {"practise", "kerf practise --student Ann"},
    {"score", "kerf score out/session.kerf"},
    {"assess", "kerf assess out/session.kerf -o out/assessment"},
    {"compare", "kerf compare scenes/paper_block.toml -o out/compare --laws all"},
    {"validate", "kerf validate -o out/validate"},
    {"calibrate", "kerf calibrate examples/synthetic_forces.csv -o out/calibrate"},
    {"study", "kerf study scenes/study_quick.toml -o out/study"},
    {"tune", "kerf tune scenes/hand_held_cut.toml --budget-us 250 -o out/tuned.toml"},
    {"stability", "kerf stability scenes/hand_held_cut.toml -o out/stability"},
    {"effects", "kerf effects scenes/hand_held_cut.toml"},
    {"paper", "kerf paper"},
    {"bench", "kerf bench tick --case disc-0.1"},
    {"bench tick", "kerf bench tick --case disc-0.1"},
    {"bench undo", "kerf bench undo"},
    {"bench hour", "kerf bench hour scenes/one_hour.toml -o out/hour"},
    {"bench growth", "kerf bench growth -o out/growth"},
    {"bench view", "kerf bench view"},
    {"bench devices", "kerf bench devices"},
    {"devices", "kerf devices"},
    {"device", "kerf device test falcon"},
    {"device test", "kerf device test falcon"},
    {"reference", "kerf reference --man out/man"},
    {"completion", "kerf completion bash > ~/.local/share/bash-completion/completions/kerf"},
};

/// Removes defaults that only mean "not given": empty lists, and the defaults of options whose help describes the
/// default in words.
void RemoveEmptyDefaults(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const std::string value = option->get_default_str();
    const bool described = option->get_description().find("default") != std::string::npos;
    // CLI11 writes an empty list as [], and from 2.4 on as {}.
    if (described || value == "[]" || value == "{}" || value == "nan") option->default_str("");
  }
  for (CLI::App* child : command.get_subcommands({})) RemoveEmptyDefaults(*child);
}

/// Refuses "" as the value of an option or argument: usually a variable of a script that is not set.
void RefuseEmptyValues(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    option->check(CLI::Validator([](std::string& text) { return text.empty() ? "must not be empty" : ""; }, ""));
  }
  for (CLI::App* child : command.get_subcommands({})) RefuseEmptyValues(*child);
}

/// Adds --no-cache to the commands that make the bone of a scene.
void AddCacheOption(CLI::App& app) {
  for (const char* const name : {"run", "loop", "replay", "rehearse", "practise", "score", "assess", "compare", "check",
                                 "effects", "stability"}) {
    if (CLI::App* const command = FindCommand(app, name); command != nullptr) {
      command->add_flag_callback(
          "--no-cache", [] { SetBoneCache(""); }, "Make the generic mandible, and do not keep it in ~/.cache/kerf");
    }
  }
}

/// Lets the inputs of a command name files that are installed with kerf.
void FindInputs(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_positional()) option->transform(FindInput);
  }
  for (CLI::App* child : command.get_subcommands({})) FindInputs(*child);
}

}  // namespace

void AddCommands(CLI::App& app) {
  app.option_defaults()->always_capture_default();
  for (const Group& group : kGroups) {
    const std::size_t before = app.get_subcommands({}).size();
    for (const auto add : group.commands) add(app);
    const std::vector<CLI::App*> commands = app.get_subcommands({});
    for (std::size_t i = before; i < commands.size(); ++i) commands[i]->group(group.name);
  }
  AddCacheOption(app);
  RemoveEmptyDefaults(app);
  FindInputs(app);
  RefuseEmptyValues(app);
  for (const Example& example : kExamples) {
    CLI::App* command = FindCommand(app, example.command);
    if (command != nullptr && !command->get_allow_extras()) command->footer(std::string("Example:\n  ") + example.line);
  }
}

CLI::App* FindCommand(CLI::App& app, const std::string& name) {
  std::istringstream words(name);
  CLI::App* at = &app;
  for (std::string word; at != nullptr && words >> word;) {
    const std::vector<CLI::App*> found = at->get_subcommands([&](const CLI::App* c) { return c->get_name() == word; });
    at = found.empty() ? nullptr : found.front();
  }
  return at;
}

}  // namespace kerf::cli
