// Folder for the results of a run, which may contain results of an earlier run.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// Returns the files that an earlier run wrote into the folder, according to the file `list` in it; only names without
/// a folder and with the extension of a result file.
std::vector<std::string> ReadEarlierResults(const std::string& folder, const std::string& list = "summary.json");
/// Returns the paths of pieces that a run may write into the folder, of those that exist or have the name of one of
/// `inputs`: how many pieces there will be is not known before the run.
std::vector<std::string> ListPieceFiles(const std::string& folder, const std::vector<std::string>& inputs);

}  // namespace kerf
