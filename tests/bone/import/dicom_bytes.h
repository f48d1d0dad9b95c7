// Changes of DICOM files that ct_files.h has written, element by element.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace kerf::test {

/// A file with explicit types, little-endian, taken apart. Sequences are not supported.
class DicomBytes {
 public:
  struct Element {
    std::uint16_t group = 0, number = 0;
    std::string vr, value;
  };

  explicit DicomBytes(const std::string& file) {
    constexpr std::size_t kMetaStart = 132;
    for (std::size_t at = kMetaStart; at < file.size();) {
      Element e{Take16(file, at), Take16(file, at + 2), file.substr(at + 4, 2), ""};
      std::size_t length = Take16(file, at + 6);
      at += 8;
      if (IsLong(e.vr)) {
        length = Take16(file, at) + (std::size_t{Take16(file, at + 2)} << 16);
        at += 4;
      }
      e.value = file.substr(at, length);
      at += length;
      (e.group == 2 ? meta_ : data_).push_back(std::move(e));
    }
  }

  /// Adds or replaces an element of the data set.
  DicomBytes& Set(std::uint16_t group, std::uint16_t number, const std::string& vr, std::string value) {
    if (value.size() % 2 != 0) value += vr == "UI" ? '\0' : ' ';
    const auto tag = std::pair(group, number);
    auto at =
        std::find_if(data_.begin(), data_.end(), [&](const Element& e) { return std::pair(e.group, e.number) >= tag; });
    if (at != data_.end() && std::pair(at->group, at->number) == tag) at = data_.erase(at);
    data_.insert(at, {group, number, vr, std::move(value)});
    return *this;
  }
  DicomBytes& Remove(std::uint16_t group, std::uint16_t number) {
    std::erase_if(data_, [&](const Element& e) { return e.group == group && e.number == number; });
    return *this;
  }

  std::string File() const { return std::string(128, '\0') + "DICM" + Meta(true) + Join(data_, true); }
  /// Without the preamble, "DICM" and the meta information.
  std::string DataSet(bool explicit_vr) const { return Join(data_, explicit_vr); }
  /// The meta information, in the way that is asked for, at byte 0; the data set has explicit types.
  std::string WithoutPreamble(bool explicit_meta) const { return Meta(explicit_meta) + Join(data_, true); }

 private:
  static std::uint16_t Take16(const std::string& file, std::size_t at) {
    std::uint16_t v = 0;
    std::memcpy(&v, &file.at(at), sizeof v);
    return v;
  }
  static bool IsLong(const std::string& vr) { return vr == "OB" || vr == "OW" || vr == "UN" || vr == "SQ"; }
  static void Append(std::string& out, std::uint32_t v, std::size_t bytes) {
    out.append(reinterpret_cast<const char*>(&v), bytes);
  }
  static std::string Join(const std::vector<Element>& elements, bool explicit_vr) {
    std::string out;
    for (const Element& e : elements) {
      Append(out, e.group, 2);
      Append(out, e.number, 2);
      const auto length = static_cast<std::uint32_t>(e.value.size());
      if (explicit_vr) out += e.vr;
      if (explicit_vr && IsLong(e.vr)) Append(out, 0, 2);
      Append(out, length, explicit_vr && !IsLong(e.vr) ? 2 : 4);
      out += e.value;
    }
    return out;
  }
  std::string Meta(bool explicit_vr) const {
    std::vector<Element> meta = meta_;
    std::vector<Element> rest(meta.begin() + 1, meta.end());
    const auto length = static_cast<std::uint32_t>(Join(rest, explicit_vr).size());
    meta.front().value = std::string(reinterpret_cast<const char*>(&length), 4);
    return Join(meta, explicit_vr);
  }

  std::vector<Element> meta_, data_;
};

}  // namespace kerf::test
