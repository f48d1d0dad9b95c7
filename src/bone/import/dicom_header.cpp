#include "bone/import/dicom_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string_view>
#include <vector>

#include "bone/import/limits.h"
#include "bone/import/unpack.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr std::uint64_t kMetaStart = 132;  // after the preamble of 128 bytes and "DICM"
constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr std::uint32_t kMaxUid = 64;  // bytes

// Encoding of the elements in a part of the file.
struct Encoding {
  bool explicit_vr = true;
  bool big_endian = false;
};

struct Element {
  std::uint16_t group = 0;
  std::uint16_t number = 0;
  std::string vr;            // empty if the file has none
  std::uint32_t length = 0;  // kUndefined: up to a delimiter
  std::uint64_t value_at = 0;

  std::string Tag() const { return fmt::format("({:04x},{:04x})", group, number); }
  std::uint64_t end() const { return value_at + length; }
};

bool IsKnownVr(std::string_view vr) {
  constexpr std::string_view kKnown =
      "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR US UT UV ";
  return vr.size() == 2 && vr[0] >= 'A' && vr[0] <= 'Z' && vr[1] >= 'A' && vr[1] <= 'Z' &&
         kKnown.find(std::string(vr) + " ") != std::string_view::npos;
}

bool HasLongLength(std::string_view vr) {
  constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV ";
  return kLong.find(std::string(vr) + " ") != std::string_view::npos;
}

class Bytes {
 public:
  Bytes(std::istream& in, const std::string& path) : path_(path), in_(in) {
    in_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(0, in_.tellg()));
  }

  std::uint64_t size() const { return size_; }

  [[noreturn]] void Refuse(const std::string& what) const {
    throw Error(fmt::format("{}: the DICOM header can't be read: {}; the file is damaged or cut off", path_, what));
  }

  std::string Text(std::uint64_t at, std::uint64_t count) {
    if (at > size_ || count > size_ - at) Refuse(fmt::format("the file ends within it, after {} bytes", size_));
    std::string text(count, '\0');
    in_.seekg(static_cast<std::streamoff>(at));
    in_.read(text.data(), static_cast<std::streamsize>(count));
    if (static_cast<std::uint64_t>(in_.gcount()) != count) Refuse("its bytes can't be read");
    return text;
  }

  std::uint32_t ReadInteger(std::uint64_t at, std::uint64_t count, bool big_endian) {
    std::string text = Text(at, count);
    if (!big_endian) std::reverse(text.begin(), text.end());
    std::uint32_t whole = 0;
    for (const char c : text) whole = whole << 8 | static_cast<unsigned char>(c);
    return whole;
  }

  // Reads tag, VR and length of the element at `at`, which must all be in the file. The VR is as stored, known or not;
  // the length is read only if the VR is known.
  Element ReadElement(std::uint64_t at, const Encoding& encoding) {
    Element e;
    e.group = static_cast<std::uint16_t>(ReadInteger(at, 2, encoding.big_endian));
    e.number = static_cast<std::uint16_t>(ReadInteger(at + 2, 2, encoding.big_endian));
    const bool delimiter = e.group == 0xfffe;  // items and the delimiters of items and sequences have no VR
    if (!encoding.explicit_vr || delimiter) {
      e.length = ReadInteger(at + 4, 4, encoding.big_endian);
      e.value_at = at + 8;
      return e;
    }
    e.vr = Text(at + 4, 2);
    if (!IsKnownVr(e.vr)) return e;
    const bool is_long = HasLongLength(e.vr);
    e.length = is_long ? ReadInteger(at + 8, 4, encoding.big_endian) : ReadInteger(at + 6, 2, encoding.big_endian);
    e.value_at = at + (is_long ? 12 : 8);
    return e;
  }

  // Checks that the element ends within the enclosing element or file, which ends at `end`.
  void CheckLength(const Element& e, std::uint64_t end) const {
    if (e.end() > end) {
      const std::uint64_t left = end - std::min(end, e.value_at);
      Refuse(fmt::format("element {} is {} bytes long but only {} are left", e.Tag(), e.length, left));
    }
  }

 private:
  std::string path_;
  std::istream& in_;
  std::uint64_t size_ = 0;
};

std::string TextWithoutPadding(Bytes& bytes, const Element& e) {
  std::string text = bytes.Text(e.value_at, e.length);
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

// Returns whether the element at `at` has a VR. The first one has a valid type if any has.
bool HasVr(Bytes& bytes, std::uint64_t at) {
  return IsKnownVr(bytes.Text(at + 4, 2));
}

// Returns the offset of the meta information, or of the data set if there is none.
std::uint64_t FindStart(Bytes& bytes) {
  const std::string head = bytes.Text(0, std::min<std::uint64_t>(bytes.size(), kMetaStart));
  if (head.size() == kMetaStart && head.ends_with("DICM")) return kMetaStart;
  if (!BeginsLikeDicom(head)) bytes.Refuse("\"DICM\" is missing after the first 128 bytes");
  return 0;
}

// Returns the offset of the data set; sets `syntax` to the UID of the transfer syntax.
std::uint64_t CheckMeta(Bytes& bytes, std::string& syntax, DicomOutline& outline) {
  std::uint64_t at = FindStart(bytes);
  Encoding encoding;
  encoding.explicit_vr = HasVr(bytes, at) || at == kMetaStart;
  while (bytes.ReadInteger(at, 2, false) == 2) {
    const Element e = bytes.ReadElement(at, encoding);
    if (e.value_at == 0) bytes.Refuse(fmt::format("element {} of the meta information has no valid type", e.Tag()));
    bytes.CheckLength(e, bytes.size());
    if (e.number == 0) {
      if ((encoding.explicit_vr && e.vr != "UL") || e.length != 4)
        bytes.Refuse("the length of the meta information is not a whole number");
      const std::uint32_t group_length = bytes.ReadInteger(e.value_at, 4, false);
      if (group_length >= bytes.size() - e.end()) {
        bytes.Refuse(fmt::format("the meta information is {} bytes long but only {} are left", group_length,
                                 bytes.size() - e.end()));
      }
    }
    if (e.number == 0x10) {
      if (e.length > kMaxUid) bytes.Refuse("the transfer syntax is not a UID");
      syntax = TextWithoutPadding(bytes, e);
    }
    if (e.number == 2 && e.length <= kMaxUid) outline.class_uid = TextWithoutPadding(bytes, e);
    at = e.end();
  }
  return at;
}

// Returns whether the value is a list of items whose elements GDCM reads: a sequence, or a value of unknown type that
// begins like one.
bool ContainsItems(Bytes& bytes, const Element& e, const Encoding& encoding) {
  constexpr std::uint32_t kItemBytes = 8;
  if (e.group == 0xfffe) return e.number == 0xe000;
  if (e.vr == "SQ") return true;
  if (!e.vr.empty() && e.vr != "UN") return false;
  return e.length >= kItemBytes && bytes.ReadInteger(e.value_at, 2, encoding.big_endian) == 0xfffe &&
         bytes.ReadInteger(e.value_at + 2, 2, encoding.big_endian) == 0xe000;
}

// Notes an element at the top of the data set.
void Note(Bytes& bytes, const Element& e, DicomOutline& outline) {
  if (e.length == 0 || e.length > kMaxUid) return;
  if (e.group == 8 && e.number == 0x16) outline.class_uid = TextWithoutPadding(bytes, e);
  if (e.group == 0x20 && e.number == 0x0e) outline.series_uid = TextWithoutPadding(bytes, e);
}

void CheckDataSet(Bytes& bytes, std::uint64_t at, const Encoding& encoding, DicomOutline& outline) {
  // The sequences and items that contain `at`, the innermost last. One that ends with a delimiter may extend to the end
  // of the enclosing one.
  struct Inside {
    std::uint64_t end;
    bool delimited;
  };
  std::vector<Inside> inside{{bytes.size(), false}};
  while (true) {
    while (inside.size() > 1 && at >= inside.back().end) inside.pop_back();
    outline.ends_early = at >= inside.back().end;
    if (outline.ends_early) return;
    const Element e = bytes.ReadElement(at, encoding);
    if (e.group == 0 || e.value_at == 0) return;  // padding, or not in the standard
    if (e.group == 0x7fe0 && inside.size() == 1 && e.number != 0) {
      outline.pixels_at = at;
      outline.ends_early = e.number == 0x10 && e.length != kUndefined && e.end() > bytes.size();
      return;
    }
    if (e.length == kUndefined && e.vr == "UN") return;  // its content has another encoding
    at = e.value_at;
    if (e.group == 0xfffe && e.number != 0xe000) {  // end of an item or a sequence
      if (inside.back().delimited) inside.pop_back();
      continue;
    }
    const bool delimited = e.length == kUndefined;
    if (!delimited) bytes.CheckLength(e, inside.back().end);
    if (!delimited && !ContainsItems(bytes, e, encoding)) {
      if (inside.size() == 1) Note(bytes, e, outline);
      at = e.end();
      continue;
    }
    if (inside.size() > kMaxDicomDepth) {
      bytes.Refuse(fmt::format("its sequences and items are nested more than {} deep", kMaxDicomDepth));
    }
    inside.push_back({delimited ? inside.back().end : e.end(), delimited});
  }
}

}  // namespace

bool BeginsLikeDicom(std::string_view head) {
  if (head.size() >= kMetaStart && head.substr(kMetaStart - 4, 4) == "DICM") return true;
  constexpr std::size_t kElementBytes = 8;
  if (head.size() < kElementBytes) return false;
  const auto byte = [&head](std::size_t i) -> unsigned { return static_cast<unsigned char>(head[i]); };
  constexpr unsigned kMaxMeta = 0x16, kMaxIdentifying = 0x70;  // the first elements of groups 2 and 8
  const unsigned group = byte(0) | byte(1) << 8U;
  const unsigned number = byte(2) | byte(3) << 8U;
  if (!(group == 2 && number <= kMaxMeta) && !(group == 8 && number <= kMaxIdentifying)) return false;
  constexpr unsigned kMaxText = 256;
  return IsKnownVr(head.substr(4, 2)) || (byte(6) == 0 && byte(7) == 0 && (byte(4) | byte(5) << 8U) <= kMaxText);
}

void CheckDicomHeader(std::istream& in, const std::string& path, DicomOutline* outline) {
  DicomOutline unused;
  DicomOutline& found = outline == nullptr ? unused : *outline;
  found = {};
  Bytes bytes(in, path);
  std::string syntax;
  const std::uint64_t data_set = CheckMeta(bytes, syntax, found);
  if (syntax == "1.2.840.10008.1.2.1.99") {  // the data set is deflated as a whole
    in.clear();
    in.seekg(static_cast<std::streamoff>(data_set));
    std::istringstream unpacked(UnpackDeflated(in, kMaxSliceBytes, path));
    Bytes unpacked_bytes(unpacked, path);
    CheckDataSet(unpacked_bytes, 0, {}, found);
    found.pixels_at = 0;
    return;
  }
  Encoding encoding;
  encoding.explicit_vr = syntax.empty() ? HasVr(bytes, data_set)
                                        : syntax != "1.2.840.10008.1.2" && syntax != "1.2.840.113619.5.2";  // GE's own
  encoding.big_endian = syntax == "1.2.840.10008.1.2.2";
  CheckDataSet(bytes, data_set, encoding, found);
}

void CheckDicomHeader(const std::string& path, DicomOutline* outline) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(fmt::format("{}: the file can't be opened", path));
  CheckDicomHeader(in, path, outline);
}

}  // namespace kerf
