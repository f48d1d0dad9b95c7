// Everything that a reader of a study sees, made from its raw figures alone.
#pragma once

#include <functional>
#include <string>

#include "experiment/study/study_csv.h"

namespace kerf {

/// Writes cases.csv, cases_times.csv, references.csv, the figures as PNG and SVG, report.md and last study.json into
/// the folder, which is there; removes figures of an earlier report that are not made again. The same results give the
/// same bytes. `progress` (may be empty) is told what is done now. Throws Error.
void WriteStudyReport(const StudyResults& study, const std::string& folder,
                      const std::function<void(const std::string&)>& progress);

}  // namespace kerf
