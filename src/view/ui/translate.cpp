#include "view/ui/translate.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>

#include "base/core/number_text.h"
#include "base/files/catalogue.h"
#include "base/files/installed.h"
#include "base/files/user_folders.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr char kDomain[] = "kerf";

std::string g_language = "en";                     // used by the window's thread only
std::atomic<const Catalogue*> g_current{nullptr};  // of that language; null: English

std::string FindUserCatalogues() {
  const std::string data = FindUserFolder(UserFolder::kData);
  return data.empty() ? data : data + "/kerf/locale";
}

/// Returns the folders that may contain catalogues: the user's, that of a build, also for its tests, and the installed
/// one.
std::vector<std::string> CatalogueFolders() {
  const std::string program = FindProgramFolder();
  return {FindUserCatalogues(), program + "/locale", program + "/../locale", FindShareFolder() + "/locale"};
}

std::string CatalogueOf(const std::string& folder, const std::string& code) {
  return fmt::format("{}/{}/LC_MESSAGES/{}.mo", folder, code, kDomain);
}

/// Returns the folder with a catalogue of the language; empty if there is none.
std::string FolderOf(const std::string& code) {
  for (const std::string& folder : CatalogueFolders()) {
    std::error_code error;
    if (!folder.empty() && fs::exists(CatalogueOf(folder, code), error)) return folder;
  }
  return {};
}

/// Returns the catalogue of a language, which stays until the end of the program; null if there is none, or if it can't
/// be read.
const Catalogue* FindCatalogue(const std::string& code) {
  static std::mutex mutex;  // protects the next one
  static std::map<std::string, std::unique_ptr<const Catalogue>> catalogues;
  const std::lock_guard lock(mutex);
  if (const auto found = catalogues.find(code); found != catalogues.end()) return found->second.get();
  const std::string folder = FolderOf(code);
  if (folder.empty()) return nullptr;
  try {
    return (catalogues[code] = std::make_unique<const Catalogue>(CatalogueOf(folder, code))).get();
  } catch (const Error&) {
    return catalogues[code].get();
  }
}

/// Returns the language that the environment asks for.
std::string FromEnvironment() {
  for (const char* name : {"LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"}) {
    const std::string text = GetVariable(name);
    if (!text.empty()) return text.substr(0, text.find_first_of("_.@:"));
  }
  return "en";
}

}  // namespace

std::vector<Language> ListLanguages() {
  std::vector<Language> languages{{"en", "English"}};
  for (const std::string& folder : CatalogueFolders()) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const std::string code = entry.path().filename().string();
      const bool known =
          std::any_of(languages.begin(), languages.end(), [&](const Language& l) { return l.code == code; });
      if (known || !fs::exists(CatalogueOf(folder, code), error)) continue;
      const Catalogue* const catalogue = FindCatalogue(code);
      if (catalogue == nullptr) continue;
      // TRANSLATORS: the name of your language in your language
      const char* const name = catalogue->Find(Msg("English"));
      languages.push_back({code, name == nullptr ? code : name});
    }
  }
  return languages;
}

void SetLanguage(const std::string& code) {
  static const std::string from_environment = FromEnvironment();
  const std::string& wanted = code.empty() ? from_environment : code;
  const Catalogue* const catalogue = FindCatalogue(wanted);
  g_language = catalogue == nullptr ? "en" : wanted;
  g_current = catalogue;
}

const std::string& CurrentLanguage() {
  return g_language;
}

const char* Tr(const char* text) {
  const Catalogue* const catalogue = g_current;
  const char* const found = catalogue == nullptr ? nullptr : catalogue->Find(text);
  return found == nullptr ? text : found;
}

std::string TrMade(const std::string& text) {
  const Catalogue* const catalogue = g_current;
  return catalogue == nullptr ? text : catalogue->Translate(text);
}

std::string TrReport(const std::string& report) {
  constexpr std::string_view kAfterName = ": ", kBetween = "; ";
  const std::size_t colon = report.find(kAfterName);
  if (colon == std::string::npos) return TrMade(report);
  const std::size_t from = colon + kAfterName.size();
  const std::string what = report.substr(from);
  std::string translated = TrMade(what);
  const std::size_t end = what.rfind(kBetween);
  if (translated == what && end != std::string::npos) {
    translated = TrMade(what.substr(0, end)) + std::string(kBetween) + TrMade(what.substr(end + kBetween.size()));
  }
  return report.substr(0, from) + translated;
}

std::string TranslateInto(const std::string& code, const std::string& text) {
  const Catalogue* const catalogue = FindCatalogue(code);
  return catalogue == nullptr ? text : catalogue->Translate(text);
}

std::string DecimalPointOf(const std::string& code) {
  const Catalogue* const catalogue = FindCatalogue(code);
  return catalogue == nullptr ? "." : std::string(catalogue->point());
}

std::string ShowNumber(double value, int decimals) {
  if (!std::isfinite(value)) return "\u2013";
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-') text.erase(0, 1);
  if (const auto dot = text.find('.'); dot != std::string::npos) text[dot] = PointOfLanguage()[0];
  return text;
}

std::optional<double> ParseNumber(std::string text) {
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return {};
  text = text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
  std::replace(text.begin(), text.end(), ',', '.');
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || at != end || !std::isfinite(number)) return {};
  return number;
}

std::string ShowDistance(double distance_mm) {
  const std::string shown = ShowNumber(distance_mm, 1);
  if (distance_mm < 0 && shown != ShowNumber(0, 1)) return Tr("blade in it");
  return fmt::format("{} mm", shown);
}

std::string ShowName(const std::string& name) {
  // The number at the end stays.
  std::size_t digits = name.size();
  while (digits > 0 && name[digits - 1] >= '0' && name[digits - 1] <= '9') --digits;
  const bool numbered = digits < name.size() && digits > 1 && name[digits - 1] == ' ';
  const std::string base = numbered ? name.substr(0, digits - 1) : name;
  const std::string ending = numbered ? name.substr(digits - 1) : std::string();
  constexpr std::string_view kMirrored = " mirrored";
  if (base.ends_with(kMirrored)) {
    const std::string of = ShowName(base.substr(0, base.size() - kMirrored.size()));
    return fmt::format(fmt::runtime(Tr("{} mirrored")), of) + ending;
  }
  for (const char* word : {Msg("plane"), Msg("stop"), Msg("piece"), Msg("nerve"), Msg("canal"), Msg("tooth"),
                           Msg("root"), Msg("other"), Msg("lesion")}) {
    if (base == word) return Tr(word) + ending;
  }
  return name;
}

std::string Translate(const Message& message) {
  return FormatMessage(
      message,
      [](const std::string& text) {
        const std::string shown = ShowName(Tr(text.c_str()));
        return shown == text ? TrMade(text) : shown;  // such as "tooth 2 from the middle, patient's left"
      },
      PointOfLanguage());
}

std::string PointOfLanguage() {
  // TRANSLATORS: the decimal separator, "." or ","
  const std::string point = Tr("decimal separator");
  return point.size() == 1 ? point : ".";
}

std::string ShowVolume(double volume_mm3) {
  const ShownVolume shown = ChooseVolumeUnit(volume_mm3);
  return fmt::format("{} {}", ShowNumber(shown.value, shown.decimals), shown.unit);
}

}  // namespace kerf
