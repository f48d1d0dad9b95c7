// The half of `kerf practise` that needs no window.
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
  std::string report;   // a page for the teacher
  std::string keys;     // of known signers
  std::string hand_in;  // a recording
  std::string bone_file;
  std::string agent;
  int agents = 0;  // all of them, with so many seeds each
  std::string exercise;
  std::string record;
  int level = 1;
  std::uint64_t seed = 1;
  double seconds = 0;  // 0: as long as the agent needs
};

void AddPractiseHistoryOptions(CLI::App& command, PractiseOptions& options);
/// Whether one of them was asked for.
bool WantsPractiseHistory(const PractiseOptions& options);
/// Does it and returns the exit code. Throws as a command's callback does.
int RunPractiseHistory(const PractiseOptions& options);

}  // namespace kerf::cli
