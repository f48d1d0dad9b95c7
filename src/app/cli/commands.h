// Commands of the program, one file for each. Only the code in this folder prints.
#pragma once

#include <CLI/CLI.hpp>

namespace kerf::cli {

// Each function adds a sub-command with its options and its callback to the program.
// The callbacks throw CLI::ValidationError for bad usage (exit code 2), and kerf::Error if they fail (exit code 1).
void AddAssessCommand(CLI::App& app);
void AddBenchCommand(CLI::App& app);
void AddCalibrateCommand(CLI::App& app);
void AddCheckCommand(CLI::App& app);
void AddCompareCommand(CLI::App& app);
void AddCompletionCommand(CLI::App& app);
void AddDeviceCommand(CLI::App& app);
void AddDevicesCommand(CLI::App& app);
void AddEffectsCommand(CLI::App& app);
void AddExportCommand(CLI::App& app);
void AddPictureCommand(CLI::App& app);
void AddInfoCommand(CLI::App& app);
void AddPaperCommand(CLI::App& app);
void AddPractiseCommand(CLI::App& app);
void AddRehearseCommand(CLI::App& app);
void AddReferenceCommand(CLI::App& app);
void AddReplayCommand(CLI::App& app);
void AddRunCommand(CLI::App& app);
void AddImportCommand(CLI::App& app);
void AddLoopCommand(CLI::App& app);
void AddLogCommand(CLI::App& app);
void AddMaterialsCommand(CLI::App& app);
void AddModelCommand(CLI::App& app);
void AddSceneCommand(CLI::App& app);
void AddScoreCommand(CLI::App& app);
void AddSlabCommand(CLI::App& app);
void AddStabilityCommand(CLI::App& app);
void AddStudyCommand(CLI::App& app);
void AddTuneCommand(CLI::App& app);
void AddValidateCommand(CLI::App& app);

}  // namespace kerf::cli
