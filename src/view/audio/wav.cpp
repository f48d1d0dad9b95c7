#include "view/audio/wav.h"

#include <fmt/format.h>
#include <sndfile.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kFullScale = 32767;

struct CloseSound {
  void operator()(SNDFILE* file) const { sf_close(file); }
};

}  // namespace

struct WavFile::State {
  PendingFile pending;
  std::unique_ptr<SNDFILE, CloseSound> file;
  std::vector<std::int16_t> block{};
  std::uint32_t samples = 0;
};

namespace {

/// Returns whether the written file is complete. libsndfile does not report every failed write, not even that of the
/// final header, and it reads a file whose header lacks sizes as if it contained them.
bool IsWhole(const std::string& file, std::uint32_t samples) {
  constexpr std::uint32_t kHeaderBytes = 44;
  const std::uint32_t bytes = sizeof(std::int16_t) * samples;
  std::array<std::uint8_t, kHeaderBytes> header{};
  std::ifstream in(file, std::ios::binary);
  for (std::uint8_t& byte : header) byte = static_cast<std::uint8_t>(in.get());
  const auto number = [&header](std::size_t at) {
    return std::uint32_t{header[at]} | std::uint32_t{header[at + 1]} << 8 | std::uint32_t{header[at + 2]} << 16 |
           std::uint32_t{header[at + 3]} << 24;
  };
  std::error_code failed;
  return in && number(4) == bytes + kHeaderBytes - 8 && number(kHeaderBytes - 4) == bytes &&
         std::filesystem::file_size(file, failed) == std::uintmax_t{bytes} + kHeaderBytes;
}

}  // namespace

WavFile::WavFile(const std::string& path, int rate_Hz) {
  PendingFile pending(path);
  SF_INFO info{};
  info.samplerate = rate_Hz;
  info.channels = 1;
  info.format = SF_FORMAT_WAV | SF_FORMAT_PCM_16;
  std::unique_ptr<SNDFILE, CloseSound> file(sf_open(pending.temporary().c_str(), SFM_WRITE, &info));
  if (file == nullptr) throw Error(fmt::format("{}: can't be written: {}", path, sf_strerror(nullptr)));
  state_ = std::make_unique<State>(State{std::move(pending), std::move(file)});
}
WavFile::~WavFile() = default;
WavFile::WavFile(WavFile&&) noexcept = default;
WavFile& WavFile::operator=(WavFile&&) noexcept = default;

void WavFile::Append(std::span<const float> samples) {
  std::vector<std::int16_t>& block = state_->block;
  block.clear();
  for (const float sample : samples) {
    if (!(std::abs(sample) <= 1)) {
      throw Error(fmt::format("{}: a sample value of {} can't be written", state_->pending.path(), sample));
    }
    block.push_back(static_cast<std::int16_t>(std::lround(kFullScale * static_cast<double>(sample))));
  }
  const auto count = static_cast<sf_count_t>(block.size());
  if (sf_write_short(state_->file.get(), block.data(), count) != count) {
    throw Error(fmt::format("{}: can't be written: {}", state_->pending.path(), sf_strerror(state_->file.get())));
  }
  state_->samples += static_cast<std::uint32_t>(count);
}

void WavFile::Commit() {
  if (sf_close(state_->file.release()) != 0 || !IsWhole(state_->pending.temporary(), state_->samples)) {
    throw Error(fmt::format("{}: can't be written completely (is the disk full?)", state_->pending.path()));
  }
  state_->pending.Commit();
}

void WriteWav(const std::string& path, int rate_Hz, const std::function<bool(std::vector<float>&)>& next) {
  WavFile file(path, rate_Hz);
  std::vector<float> samples;
  bool more = true;
  while (more) {
    samples.clear();
    more = next(samples);
    file.Append(samples);
  }
  file.Commit();
}

}  // namespace kerf
