// The part of `kerf practise` that needs no window.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace kerf::cli {

struct PractiseOptions {
  bool list = false;
  bool history = false;
  bool json = false;
  bool csv = false;
  std::string student;
  std::string report;   // output file of a page for the teacher
  std::string keys;     // file with keys of known signers
  std::string hand_in;  // recording to hand in
  std::string bone_file;
  std::string agent;
  int agents = 0;  // number of seeds with which to run all agents; 0: none
  std::string exercise;
  std::string record;
  int level = 1;
  std::uint64_t seed = 1;
  double seconds = 0;  // 0: as long as the agent needs
};

void AddPractiseHistoryOptions(CLI::App& command, PractiseOptions& options);
/// Returns true if one of the options was given.
bool WantsPractiseHistory(const PractiseOptions& options);
/// Executes the options and returns the exit code. Throws the same errors as a command's callback.
int RunPractiseHistory(const PractiseOptions& options);

}  // namespace kerf::cli
