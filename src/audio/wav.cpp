#include "audio/wav.h"

#include <fmt/format.h>
#include <sndfile.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "files/files.h"
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
};

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
      throw Error(fmt::format("{}: a sample of {} can't be written", state_->pending.path(), sample));
    }
    block.push_back(static_cast<std::int16_t>(std::lround(kFullScale * static_cast<double>(sample))));
  }
  const auto count = static_cast<sf_count_t>(block.size());
  if (sf_write_short(state_->file.get(), block.data(), count) != count) {
    throw Error(fmt::format("{}: can't be written: {}", state_->pending.path(), sf_strerror(state_->file.get())));
  }
}

void WavFile::Commit() {
  if (sf_close(state_->file.release()) != 0) {
    throw Error(fmt::format("{}: can't be written: it could not be closed", state_->pending.path()));
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
