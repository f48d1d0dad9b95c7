// Tables and sentences of a study report in Markdown, all generated from its figures.
#pragma once

#include <string>

#include "experiment/study/pooled.h"

namespace kerf {

/// Three significant digits: "2.98", "0.0312", "1230".
std::string ShowThree(double value);
/// A fraction in per cent: "2.98 %", "at most 0.12 %".
std::string ShowError(const SafeError& error);
std::string ShowFraction(double fraction);
/// "+2.98 %", "-14.1 %", "0 %".
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

/// Findings for one way of holding the tool, one bullet each.
std::string DescribeFindings(const StudyResults& study, Holding holding);

/// Returns the paths on which slab mode was run.
std::vector<std::string> PathsOfSlab(const StudyResults& study, Holding holding);

}  // namespace kerf
