#include "bone/import/dicom_charset.h"

#include <iconv.h>

#include <algorithm>
#include <array>

#include "base/core/printable.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxCharacters = 1000;
constexpr std::size_t kMaxTextBytes = 4 * kMaxCharacters;
constexpr char kEscape = '\x1b';

struct CharacterSet {
  std::string_view number;  // in "ISO_IR 100" and "ISO 2022 IR 100"
  const char* name;         // for iconv; its bytes above 127 are those of the set
};
constexpr std::array kCharacterSets{
    CharacterSet{"100", "ISO-8859-1"},  CharacterSet{"101", "ISO-8859-2"}, CharacterSet{"109", "ISO-8859-3"},
    CharacterSet{"110", "ISO-8859-4"},  CharacterSet{"144", "ISO-8859-5"}, CharacterSet{"127", "ISO-8859-6"},
    CharacterSet{"126", "ISO-8859-7"},  CharacterSet{"138", "ISO-8859-8"}, CharacterSet{"148", "ISO-8859-9"},
    CharacterSet{"203", "ISO-8859-15"}, CharacterSet{"166", "TIS-620"},    CharacterSet{"13", "SHIFT_JIS"},
    CharacterSet{"149", "EUC-KR"},      CharacterSet{"58", "GB2312"},      CharacterSet{"192", "UTF-8"}};

// How the bytes 33 to 126 are read.
enum class Low { kAscii, kKanji, kMoreKanji };

struct Escape {
  std::string_view sequence;  // without the escape character
  Low low;
  const char* high;  // for the bytes above 127; null: unchanged
};
// PS3.3 C.12.1.1.2.
constexpr std::array kEscapes{Escape{"(B", Low::kAscii, nullptr},      Escape{"(J", Low::kAscii, nullptr},
                              Escape{")I", Low::kAscii, "SHIFT_JIS"},  Escape{"$B", Low::kKanji, nullptr},
                              Escape{"$@", Low::kKanji, nullptr},      Escape{"$(D", Low::kMoreKanji, nullptr},
                              Escape{"$)C", Low::kAscii, "EUC-KR"},    Escape{"$)A", Low::kAscii, "GB2312"},
                              Escape{"-A", Low::kAscii, "ISO-8859-1"}, Escape{"-B", Low::kAscii, "ISO-8859-2"},
                              Escape{"-C", Low::kAscii, "ISO-8859-3"}, Escape{"-D", Low::kAscii, "ISO-8859-4"},
                              Escape{"-L", Low::kAscii, "ISO-8859-5"}, Escape{"-G", Low::kAscii, "ISO-8859-6"},
                              Escape{"-F", Low::kAscii, "ISO-8859-7"}, Escape{"-H", Low::kAscii, "ISO-8859-8"},
                              Escape{"-M", Low::kAscii, "ISO-8859-9"}, Escape{"-b", Low::kAscii, "ISO-8859-15"},
                              Escape{"-T", Low::kAscii, "TIS-620"}};

// Returns the bytes in UTF-8, with '?' in place of what is not in the character set.
std::string ConvertToUtf8(std::string_view bytes, const char* name) {
  const iconv_t converter = iconv_open("UTF-8", name);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): how iconv_open() reports an error
  if (converter == reinterpret_cast<iconv_t>(-1)) return std::string(bytes.size(), '?');
  std::string input(bytes);
  char* in = input.data();
  std::size_t left = input.size();
  std::string text;
  while (left > 0) {
    std::array<char, 512> block;
    char* out = block.data();
    std::size_t room = block.size();
    const std::size_t before = left;
    iconv(converter, &in, &left, &out, &room);
    text.append(block.data(), block.size() - room);
    if (left == before && room == block.size()) {  // not in the character set, or cut off
      text += '?';
      ++in;
      --left;
    }
  }
  iconv_close(converter);
  return text;
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const FirstCharacter first = FindFirstCharacter(text);
    if (first.bytes == 1 && static_cast<unsigned char>(text[0]) >= 0x80) return false;
    text.remove_prefix(first.bytes);
  }
  return true;
}

// Returns the name of the first character set for iconv; null for ASCII, or a set that is not known.
const char* FindFirstSet(std::string_view character_sets) {
  std::string_view first = character_sets.substr(0, character_sets.find('\\'));
  while (first.ends_with(' ')) first.remove_suffix(1);
  if (first == "GB18030" || first == "GBK") return "GB18030";
  const std::size_t number = first.find_last_of(' ') + 1;
  for (const CharacterSet& set : kCharacterSets) {
    if (number > 0 && first.substr(number) == set.number) return set.name;
  }
  return nullptr;
}

// Reads a text with escape sequences (ISO 2022).
class EscapedText {
 public:
  EscapedText(std::string_view text, const char* first_set) : rest_(text), first_(first_set), high_(first_set) {}

  std::string Decode() {
    std::string decoded;
    while (!rest_.empty()) decoded += TakePart();
    return decoded;
  }

 private:
  std::string TakePart() {
    if (rest_.front() == kEscape) return TakeEscape();
    const auto byte = [](char c) { return static_cast<unsigned char>(c); };
    if (byte(rest_.front()) >= 0x80) {
      const std::string_view part = TakeWhile([&](char c) { return byte(c) >= 0x80; });
      return ConvertToUtf8(part, high_ == nullptr ? "ISO-8859-1" : high_);
    }
    const auto is_half = [&](char c) { return byte(c) > 0x20 && byte(c) < 0x7f; };
    if (low_ != Low::kAscii && is_half(rest_.front())) return DecodeKanji(TakeWhile(is_half));
    const char c = rest_.front();
    rest_.remove_prefix(1);
    // Delimiters of values and of parts of a name end what escape sequences have set.
    if (c == '\\' || c == '^' || c == '=' || c < ' ') {
      low_ = Low::kAscii;
      high_ = first_;
    }
    return {c};
  }

  std::string TakeEscape() {
    rest_.remove_prefix(1);
    const auto* const found = std::find_if(kEscapes.begin(), kEscapes.end(),
                                           [this](const Escape& e) { return rest_.starts_with(e.sequence); });
    if (found == kEscapes.end()) return "?";
    rest_.remove_prefix(found->sequence.size());
    low_ = found->low;
    if (found->high != nullptr) high_ = found->high;
    return "";
  }

  // Two bytes are a character of JIS X 0208 or 0212, which EUC-JP has with the highest bits set.
  std::string DecodeKanji(std::string_view part) const {
    std::string euc;
    for (std::size_t i = 0; i + 1 < part.size(); i += 2) {
      if (low_ == Low::kMoreKanji) euc += '\x8f';
      euc += static_cast<char>(part[i] | 0x80);
      euc += static_cast<char>(part[i + 1] | 0x80);
    }
    return ConvertToUtf8(euc, "EUC-JP") + (part.size() % 2 == 0 ? "" : "?");
  }

  template <typename Matches>
  std::string_view TakeWhile(const Matches& matches) {
    std::size_t count = 0;
    while (count < rest_.size() && matches(rest_[count])) ++count;
    const std::string_view part = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return part;
  }

  std::string_view rest_;
  const char* first_;
  const char* high_;
  Low low_ = Low::kAscii;
};

}  // namespace

std::string DecodeDicomText(std::string_view text, std::string_view character_sets) {
  text = text.substr(0, kMaxTextBytes);
  const char* const first = FindFirstSet(character_sets);
  std::string decoded;
  if (first != nullptr && (std::string_view(first) == "GB18030" || std::string_view(first) == "UTF-8")) {
    decoded = ConvertToUtf8(text, first);
  } else if (first == nullptr && text.find(kEscape) == std::string_view::npos && IsUtf8(text)) {
    decoded = text;
  } else {
    decoded = EscapedText(text, first).Decode();
  }
  return FirstCharacters(Printable(decoded), kMaxCharacters);
}

}  // namespace kerf
