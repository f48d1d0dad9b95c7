// Tables and sentences of a study report in Markdown, all generated from its figures.
#pragma once

#include <string>

#include "base/core/number_text.h"
#include "experiment/study/pooled.h"

namespace kerf {

/// Formats a fraction as a percentage: "2.98 %", "at most 0.120 %".
std::string ShowError(const SafeError& error);
std::string ShowFraction(double fraction);
/// Formats a fraction as a percentage with its sign: "+2.98 %", "-14.1 %", "0 %".
std::string ShowSignedFraction(double fraction);

/// Each table ends with an empty line; the text is empty if there is nothing to report.
std::string DefaultsTable(const StudyResults& study, Holding holding);
std::string EqualTimeTable(const StudyResults& study, Holding holding);
std::string EqualErrorTable(const StudyResults& study, Holding holding);
std::string SettingsTable(const StudyResults& study, Holding holding);
std::string OrdersTable(const StudyResults& study, Holding holding);
std::string SlabTable(const StudyResults& study, Holding holding);
std::string LeftOutTable(const StudyResults& study);
std::string ReferencesTable(const StudyResults& study);

/// Describes the findings for one way of holding the tool, each as a bullet.
std::string DescribeFindings(const StudyResults& study, Holding holding);

/// Returns the paths on which slab mode was run.
std::vector<std::string> PathsOfSlab(const StudyResults& study, Holding holding);

}  // namespace kerf
