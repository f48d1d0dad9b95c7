// Translation of the texts of the window, with catalogues of GNU gettext.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/core/message.h"

namespace kerf {

/// Language of the window: its code ("en", "de") and its own name ("Deutsch").
struct Language {
  std::string code;
  std::string name;
};

/// Returns English and the languages for which a catalogue was found. A catalogue is a file
/// FOLDER/CODE/LC_MESSAGES/kerf.mo in ~/.local/share/kerf/locale, or in the folder of the program's own catalogues,
/// which is beside the program or in share/locale of its installation.
std::vector<Language> ListLanguages();
/// Sets the language of Tr(). Empty: that of the environment (LANGUAGE, LC_ALL, LC_MESSAGES, LANG); a language without
/// catalogue gives English. Called by the window's thread only.
void SetLanguage(const std::string& code);
/// Returns the code of the current language. Called by the window's thread only.
const std::string& CurrentLanguage();

/// Returns the translation of a text, which must be a literal, so that tools/translations finds it, or come from data
/// that tools/translations lists. An empty text stays empty. The result is valid until the end of the program.
const char* Tr(const char* text);
/// Translates a text that was made below the window and may contain values, such as an error: see
/// Catalogue::Translate(). May be called by any thread.
std::string TrMade(const std::string& text);
/// Does the same for a report of a device, "NAME: WHAT" or "NAME: WHAT; WHAT". The name stays.
std::string TrReport(const std::string& report);
/// Does what TrMade() does, into the language with this code, whatever the language of the window is.
std::string TranslateInto(const std::string& code, const std::string& text);
/// Returns the decimal separator of that language.
std::string DecimalPointOf(const std::string& code);
/// Marks a text that is translated later by Tr().
constexpr const char* Msg(const char* text) {
  return text;
}

/// Formats a number for the screen, with the decimal separator of the language.
std::string ShowNumber(double value, int decimals);
/// Reads a number as a user types it, with "." or "," before the decimals. None if the text is anything else.
std::optional<double> ParseNumber(std::string text);
/// Formats the distance to a structure with its unit; a negative one says that the blade is in it.
std::string ShowDistance(double distance_mm);
/// Translates a name that the program has made, such as "plane 2 mirrored" or "nerve". Other names stay as they are.
std::string ShowName(const std::string& name);
/// Returns the message in the current language. Its texts may be names, as for ShowName().
std::string Translate(const Message& message);
/// Returns the decimal separator of the language.
std::string PointOfLanguage();
/// Formats a volume with its unit: in cm³, or in mm³ if it is less than 0.1 cm³.
std::string ShowVolume(double volume_mm3);

}  // namespace kerf
