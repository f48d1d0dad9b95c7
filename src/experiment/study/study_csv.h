// The raw figures of a study in a folder: cases.csv, cases_times.csv, references.csv and study.json. All diagrams and
// reports of a study are generated from these files alone.
#pragma once

#include <string>
#include <vector>

#include "experiment/study/records.h"

namespace kerf {

/// One row for each case. Column names end in their unit; `_jnd`: the preceding column in just-noticeable differences
/// (records.h). A missing value is an empty field. Numbers read back bit for bit; control characters in words become
/// spaces.
std::string FormatCasesCsv(const StudyResults& study);
/// Times of all ticks as histograms: id, bucket of LogHistogram, its upper edge (us), ticks in it.
std::string FormatTimesCsv(const StudyResults& study);
std::string FormatReferencesCsv(const StudyResults& study);
/// All other data. `files`: names of the other files in the folder.
std::string FormatStudyJson(const StudyResults& study, const std::vector<std::string>& files);

/// Reads the four files of a folder. Throws Error for the first fault, giving file and line.
StudyResults ReadStudyResults(const std::string& folder);

}  // namespace kerf
