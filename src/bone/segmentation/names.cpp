// The meaning of names and SNOMED CT codes of segments.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <map>
#include <string_view>
#include <vector>

#include "bone/material/segment_regions.h"
#include "bone/segmentation/roles.h"

namespace kerf {

namespace {

using Words = std::vector<std::string>;

// Splits a name into words in lower case, with German umlauts written in ASCII.
Words SplitWords(const std::string& name) {
  static const std::array<std::pair<std::string_view, std::string_view>, 7> kUmlauts = {{{"\xc3\xa4", "ae"},
                                                                                         {"\xc3\xb6", "oe"},
                                                                                         {"\xc3\xbc", "ue"},
                                                                                         {"\xc3\x84", "ae"},
                                                                                         {"\xc3\x96", "oe"},
                                                                                         {"\xc3\x9c", "ue"},
                                                                                         {"\xc3\x9f", "ss"}}};
  std::string text = name;
  for (const auto& [from, to] : kUmlauts) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos;) text.replace(at, from.size(), to);
  }
  Words words;
  std::string word;
  for (const char c : text + " ") {
    const auto u = static_cast<unsigned char>(c);
    const bool is_digit = std::isdigit(u) != 0;
    // A number is a word of its own, so that "fdi36" and "tooth36" are two words.
    const bool begins_number = is_digit && !word.empty() && std::isdigit(static_cast<unsigned char>(word.back())) == 0;
    if (std::isalnum(u) == 0 || begins_number) {
      if (!word.empty()) words.push_back(word);
      word.clear();
    }
    if (std::isalnum(u) != 0) word += static_cast<char>(std::tolower(u));
  }
  return words;
}

bool HasOne(const Words& words, std::initializer_list<const char*> list) {
  return std::any_of(list.begin(), list.end(),
                     [&words](const char* w) { return std::find(words.begin(), words.end(), w) != words.end(); });
}

JawPart JawOf(int fdi) {
  const int quadrant = (fdi / 10 - 1) % 4;  // deciduous teeth have the quadrants 5 to 8
  return quadrant < 2 ? JawPart::kUpper : JawPart::kLower;
}

JawSide FindSide(const Words& words) {
  const bool left = HasOne(words, {"left", "l", "links", "linker", "linke", "linkes"});
  const bool right = HasOne(words, {"right", "r", "rechts", "rechter", "rechte", "rechtes"});
  if (left == right) return JawSide::kUnknown;
  return left ? JawSide::kLeft : JawSide::kRight;
}

JawPart FindJaw(const Words& words) {
  const bool lower = HasOne(words, {"lower", "mandibular", "mandible", "inferior", "untere", "unterer", "unteren",
                                    "unterkiefer", "unterkieferzaehne", "unterkieferzahn", "uk"});
  const bool upper = HasOne(words, {"upper", "maxillary", "maxilla", "superior", "obere", "oberer", "oberen",
                                    "oberkiefer", "oberkieferzaehne", "oberkieferzahn", "ok"});
  if (lower == upper) return JawPart::kUnknown;
  return lower ? JawPart::kLower : JawPart::kUpper;
}

// Returns the number of a tooth in words, such as "lower left first molar"; 0 if the words do not give one.
int FindWordedNumber(const Words& words) {
  const JawPart jaw = FindJaw(words);
  const JawSide side = FindSide(words);
  if (jaw == JawPart::kUnknown || side == JawSide::kUnknown) return 0;
  const bool second = HasOne(words, {"second"}), third = HasOne(words, {"third"}), first = HasOne(words, {"first"});
  int n = 0;
  if (HasOne(words, {"incisor"})) n = HasOne(words, {"central"}) ? 1 : HasOne(words, {"lateral"}) ? 2 : 0;
  if (HasOne(words, {"canine"})) n = 3;
  if (HasOne(words, {"premolar"})) n = first ? 4 : second ? 5 : 0;
  if (HasOne(words, {"molar"})) n = first ? 6 : second ? 7 : third ? 8 : 0;
  if (n == 0) return 0;
  const int quadrant = jaw == JawPart::kUpper ? (side == JawSide::kRight ? 1 : 2) : (side == JawSide::kLeft ? 3 : 4);
  return 10 * quadrant + n;
}

bool IsTooth(const Words& words) {
  return HasOne(words, {"tooth",
                        "teeth",
                        "zahn",
                        "zaehne",
                        "fdi",
                        "dentition",
                        "dentes",
                        "incisor",
                        "incisors",
                        "canine",
                        "canines",
                        "premolar",
                        "premolars",
                        "molar",
                        "molars",
                        "pulp",
                        "unterkieferzaehne",
                        "oberkieferzaehne",
                        "unterkieferzahn",
                        "oberkieferzahn",
                        "weisheitszahn"}) ||
         (HasOne(words, {"root"}) && HasOne(words, {"canal", "canals"}));
}

SegmentMeaning MakeTooth(const Words& words) {
  SegmentMeaning tooth{.role = SegmentRole::kTooth, .fdi = 0, .jaw = FindJaw(words), .side = JawSide::kUnknown};
  for (const std::string& word : words) {
    if (word.size() > 3 || !std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isdigit(c) != 0; }))
      continue;
    // TotalSegmentator numbers the pulp of a tooth 100 higher.
    const int number = std::stoi(word) % 100;
    if (IsToothNumber(number)) tooth.fdi = number;
  }
  const int worded = FindWordedNumber(words);
  if (tooth.fdi == 0) tooth.fdi = worded;
  if (tooth.fdi != 0 && tooth.jaw == JawPart::kUnknown) tooth.jaw = JawOf(tooth.fdi);
  // Other systems of numbers exist; a number that contradicts the jaw is one of them.
  if (tooth.fdi != 0 && JawOf(tooth.fdi) != tooth.jaw) tooth.fdi = 0;
  return tooth;
}

bool IsCanal(const Words& words) {
  if (HasOne(words, {"mandibularkanal", "unterkieferkanal", "nervkanal", "nervenkanal", "ian", "iac", "ianc"}))
    return true;
  if (!HasOne(words, {"canal", "canals", "canalis", "kanal", "nerve", "nerves", "nerv", "nervus"})) return false;
  if (words.size() == 1 || (HasOne(words, {"canal"}) && HasOne(words, {"nerve"}))) return true;
  if (words.size() == 2 && FindSide(words) != JawSide::kUnknown) return true;
  return HasOne(words, {"mandibular", "mandible", "mandibularis", "mandibulae", "alveolar", "alveolaris", "incisive",
                        "lingual", "unterkiefer"}) &&
         !HasOne(words, {"superior", "maxillary", "maxilla"});
}

bool IsOtherBone(const Words& words) {
  if (HasOne(
          words,
          {"maxilla",  "skull",     "cranium",  "cranial",    "cranio",  "zygoma",    "zygomatic",  "temporal",
           "sphenoid", "occipital", "parietal", "frontal",    "ethmoid", "nasal",     "vomer",      "palate",
           "palatine", "hyoid",     "vertebra", "vertebrae",  "spine",   "atlas",     "axis",       "fibula",
           "tibia",    "femur",     "scapula",  "clavicle",   "sternum", "pterygoid", "oberkiefer", "oberkieferknochen",
           "schaedel", "jochbein",  "wirbel",   "zungenbein", "max",     "cb"}))
    return true;
  return HasOne(words, {"upper", "maxillary"}) && HasOne(words, {"jaw", "jawbone", "bone"});
}

bool IsMandible(const Words& words) {
  if (HasOne(words, {"mandible", "mandibula", "unterkiefer", "unterkieferknochen", "mand", "mandibule"})) return true;
  return (HasOne(words, {"lower"}) && HasOne(words, {"jaw", "jawbone"})) ||
         (HasOne(words, {"mandibular"}) && HasOne(words, {"bone"}));
}

// SNOMED CT codes of the permanent teeth: DICOM part 16, CID 4018.
const std::map<std::string, int>& ToothCodes() {
  static const std::map<std::string, int> kCodes = {
      {"422653006", 11}, {"424877001", 12}, {"860767006", 13}, {"57826002", 14},  {"36492000", 15},  {"865995000", 16},
      {"863902006", 17}, {"68085002", 18},  {"424399000", 21}, {"423185002", 22}, {"860780009", 23}, {"61897005", 24},
      {"23226009", 25},  {"865988009", 26}, {"863901004", 27}, {"87704003", 28},  {"425106001", 31}, {"423331005", 32},
      {"860782001", 33}, {"2400006", 34},   {"24573005", 35},  {"866006002", 36}, {"863898000", 37}, {"74344005", 38},
      {"424575004", 41}, {"423937004", 42}, {"860785004", 43}, {"80140008", 44},  {"8873007", 45},   {"866005003", 46},
      {"863899008", 47}, {"38994002", 48}};
  return kCodes;
}

}  // namespace

std::optional<SegmentMeaning> FindMeaning(const std::string& name) {
  const Words words = SplitWords(name);
  const auto is = [](SegmentRole role) { return SegmentMeaning{.role = role}; };
  if (HasOne(words, {"sinus", "sinuses", "pharynx", "airway", "skin", "head", "face", "tongue", "muscle", "fat",
                     "brain", "background", "tissue", "kieferhoehle", "haut", "luft", "air"}))
    return is(SegmentRole::kIgnored);
  if (HasOne(words,
             {"lesion", "lesions", "tumor", "tumour", "cyst", "keratocyst", "ameloblastoma", "zyste", "laesion"}))
    return is(SegmentRole::kLesion);
  if (!HasOne(words, {"root", "pulp"}) && IsCanal(words)) {
    SegmentMeaning canal = is(SegmentRole::kCanal);
    canal.side = FindSide(words);
    return canal;
  }
  if (IsTooth(words)) return MakeTooth(words);
  if (IsOtherBone(words)) return is(SegmentRole::kOtherBone);
  if (HasOne(words, {"implant", "implants", "plate",   "plates",  "screw",   "screws",   "crown",
                     "crowns",  "bridge",   "bridges", "metal",   "filling", "fillings", "implantat",
                     "platte",  "schraube", "krone",   "bruecke", "metall",  "fuellung"}))
    return is(SegmentRole::kMetal);
  // "not the mandible", a part that is cut out of it, or its marrow is not the mandible.
  if (HasOne(words, {"not", "non", "no", "without", "minus", "resection", "resected", "resektat", "resektion", "ohne",
                     "marrow", "mark", "knochenmark"}))
    return std::nullopt;
  if (IsMandible(words)) return is(SegmentRole::kMandible);
  return std::nullopt;
}

std::optional<SegmentMeaning> FindCodedMeaning(const Segment& segment) {
  // DICOM part 16: category "Morphologically Abnormal Structure"; CID 4016, 4028 and 7166 for the others.
  if (segment.category == "49755003") return SegmentMeaning{.role = SegmentRole::kLesion};
  static const std::map<std::string, SegmentRole> kRoles = {{"91609006", SegmentRole::kMandible},
                                                            {"70925003", SegmentRole::kOtherBone},  // maxilla
                                                            {"89546000", SegmentRole::kOtherBone},  // skull
                                                            {"38199008", SegmentRole::kTooth},
                                                            {"40388003", SegmentRole::kMetal}};  // implant
  for (const std::string& code : segment.codes) {
    if (const auto tooth = ToothCodes().find(code); tooth != ToothCodes().end())
      return SegmentMeaning{.role = SegmentRole::kTooth, .fdi = tooth->second, .jaw = JawOf(tooth->second)};
    if (const auto role = kRoles.find(code); role != kRoles.end()) return SegmentMeaning{.role = role->second};
  }
  return std::nullopt;
}

SegmentCodes FindCodes(const std::optional<SegmentMeaning>& meaning) {
  const DicomCode anatomy{"123037004", "SCT", "Anatomical Structure"};
  switch (meaning ? meaning->role : SegmentRole::kOtherBone) {
    case SegmentRole::kMandible:
      return {anatomy, {"91609006", "SCT", "Mandible"}};
    case SegmentRole::kTooth:
      for (const auto& [code, fdi] : ToothCodes()) {
        if (fdi == meaning->fdi) return {anatomy, {code, "SCT", fmt::format("Tooth {} of ISO 3950", fdi)}};
      }
      return {anatomy, {"38199008", "SCT", "Tooth"}};
    case SegmentRole::kCanal:
      return {anatomy, {"canal", "99KERF", "Canal of the nerve"}};
    case SegmentRole::kMetal:
      return {{"260787004", "SCT", "Physical object"}, {"40388003", "SCT", "Implant"}};
    case SegmentRole::kLesion:
      return {{"49755003", "SCT", "Morphologically Abnormal Structure"}, {"52988006", "SCT", "Lesion"}};
    default:
      return {anatomy, {"272673000", "SCT", "Bone"}};
  }
}

}  // namespace kerf
