#include "experiment/study/reference_store.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "base/core/hash.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// Contents of a file: mark, version, hash of the input, figures, note, ticks; then a checksum of everything before it.
// Numbers are stored in the format of this machine, because every machine computes its own references.
constexpr std::string_view kMark = "kerfref\n";
constexpr std::uint64_t kVersion = 2;
constexpr std::uint64_t kMaxTicks = 10'000'000;

std::uint64_t CalcChecksum(std::string_view bytes) {
  std::uint64_t sum = MixHash(bytes.size());
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min<std::size_t>(8, bytes.size() - i));
    sum = MixHash(sum ^ word);
  }
  return sum;
}

class Writer {
 public:
  template <typename Number>
  void Add(Number number) {
    std::array<char, sizeof(Number)> bytes;
    std::memcpy(bytes.data(), &number, sizeof(Number));
    text_.append(bytes.data(), bytes.size());
  }
  void Add(const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) Add(v[axis]);
  }
  void AddText(std::string_view text) { text_.append(text); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : text_(text), file_(file) {}
  template <typename Number>
  Number Take() {
    Number number;
    std::memcpy(&number, TakeText(sizeof(Number)).data(), sizeof(Number));
    return number;
  }
  Vec3 TakeVector() {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = Take<double>();
    return v;
  }
  std::string_view TakeText(std::size_t size) {
    if (size > text_.size()) Fail();
    const std::string_view part = text_.substr(0, size);
    text_.remove_prefix(size);
    return part;
  }
  bool empty() const { return text_.empty(); }
  [[noreturn]] void Fail() const { throw Error(fmt::format("{}: is damaged or not a reference of a study", file_)); }

 private:
  std::string_view text_;
  const std::string& file_;
};

}  // namespace

std::optional<StudyReference> ReadStudyReference(const std::string& file, std::uint64_t input_hash) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  const std::string text = ReadTextFile(file, std::size_t{2} << 30);
  Reader reader(text, file);
  if (reader.TakeText(kMark.size()) != kMark) reader.Fail();
  if (text.size() < kMark.size() + 24) reader.Fail();
  const std::size_t body = text.size() - 8;
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, text.data() + body, 8);
  if (CalcChecksum(std::string_view(text).substr(0, body)) != checksum) reader.Fail();
  if (reader.Take<std::uint64_t>() != kVersion) return std::nullopt;
  StudyReference reference;
  ReferenceRecord& record = reference.record;
  record.input_hash = reader.Take<std::uint64_t>();
  if (record.input_hash != input_hash) return std::nullopt;
  record.force_hash = reader.Take<std::uint64_t>();
  record.steps_per_tick = static_cast<int>(reader.Take<std::int64_t>());
  record.error_bar = reader.Take<double>();
  record.error_bar_l2 = reader.Take<double>();
  record.volume_bar = reader.Take<double>();
  record.seconds = reader.Take<double>();
  reference.tick_s = reader.Take<double>();
  reference.removed_mm3 = reader.Take<double>();
  record.note = reader.TakeText(reader.Take<std::uint64_t>());
  const auto count = reader.Take<std::uint64_t>();
  if (count > kMaxTicks) reader.Fail();
  reference.ticks.resize(count);
  for (ReferenceTick& tick : reference.ticks) {
    Quat& q = tick.X_WT.R_AB;
    q.w = reader.Take<double>();
    q.x = reader.Take<double>();
    q.y = reader.Take<double>();
    q.z = reader.Take<double>();
    tick.X_WT.p_AB = reader.TakeVector();
    tick.f_W_N = reader.TakeVector();
    tick.thrust_sum_N = reader.Take<double>();
    tick.engaged_teeth = reader.Take<double>();
    tick.removed_mm3 = reader.Take<double>();
  }
  reader.Take<std::uint64_t>();
  if (!reader.empty()) reader.Fail();
  return reference;
}

void WriteStudyReference(const StudyReference& reference, const std::string& file) {
  const ReferenceRecord& record = reference.record;
  Writer writer;
  writer.AddText(kMark);
  writer.Add(kVersion);
  writer.Add(record.input_hash);
  writer.Add(record.force_hash);
  writer.Add(std::int64_t{record.steps_per_tick});
  writer.Add(record.error_bar);
  writer.Add(record.error_bar_l2);
  writer.Add(record.volume_bar);
  writer.Add(record.seconds);
  writer.Add(reference.tick_s);
  writer.Add(reference.removed_mm3);
  writer.Add(std::uint64_t{record.note.size()});
  writer.AddText(record.note);
  writer.Add(std::uint64_t{reference.ticks.size()});
  for (const ReferenceTick& tick : reference.ticks) {
    const Quat& q = tick.X_WT.R_AB;
    for (const double value : {q.w, q.x, q.y, q.z}) writer.Add(value);
    writer.Add(tick.X_WT.p_AB);
    writer.Add(tick.f_W_N);
    writer.Add(tick.thrust_sum_N);
    writer.Add(tick.engaged_teeth);
    writer.Add(tick.removed_mm3);
  }
  writer.Add(CalcChecksum(writer.text()));
  WriteTextFile(file, writer.text());
}

}  // namespace kerf
