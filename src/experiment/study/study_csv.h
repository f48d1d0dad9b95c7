// The raw figures of a study in a folder: cases.csv, cases_times.csv, references.csv and study.json. All diagrams and
// reports of a study are generated from these files alone.
#pragma once

#include <string>
#include <vector>

#include "experiment/study/records.h"

namespace kerf {

/// Formats one row for each case. Column names end in the unit; a column ending in `_jnd` contains the preceding one in
/// just-noticeable differences (records.h). A missing value is an empty field. Numbers read back bit for bit; control
/// characters in words become spaces.
std::string FormatCasesCsv(const StudyResults& study);
/// Formats the times of all ticks as histograms, with the columns id, bucket of LogHistogram, its upper edge (us) and
/// the number of ticks in it.
std::string FormatTimesCsv(const StudyResults& study);
std::string FormatReferencesCsv(const StudyResults& study);
/// Formats all other data. `files`: names of the other files in the folder.
std::string FormatStudyJson(const StudyResults& study, const std::vector<std::string>& files);

/// Reads the four files of a folder. Throws Error for the first fault, giving file and line.
StudyResults ReadStudyResults(const std::string& folder);

}  // namespace kerf
