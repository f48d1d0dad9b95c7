#include "audio/wav.h"

#include <fmt/format.h>
#include <sndfile.h>

#include <cmath>
#include <cstdint>
#include <memory>

#include "files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kFullScale = 32767;

struct CloseSound {
  void operator()(SNDFILE* file) const { sf_close(file); }
};

}  // namespace

void WriteWav(const std::string& path, int rate_Hz, const std::function<bool(std::vector<float>&)>& next) {
  WriteAtomically(path, [&](const std::string& temporary) {
    SF_INFO info{};
    info.samplerate = rate_Hz;
    info.channels = 1;
    info.format = SF_FORMAT_WAV | SF_FORMAT_PCM_16;
    std::unique_ptr<SNDFILE, CloseSound> file(sf_open(temporary.c_str(), SFM_WRITE, &info));
    if (file == nullptr) throw Error(fmt::format("can't write {}: {}", path, sf_strerror(nullptr)));
    std::vector<float> samples;
    std::vector<std::int16_t> block;
    bool more = true;
    while (more) {
      samples.clear();
      more = next(samples);
      block.clear();
      for (const float sample : samples) {
        if (!(std::abs(sample) <= 1)) throw Error(fmt::format("{}: a sample of {} can't be written", path, sample));
        block.push_back(static_cast<std::int16_t>(std::lround(kFullScale * static_cast<double>(sample))));
      }
      const auto count = static_cast<sf_count_t>(block.size());
      if (sf_write_short(file.get(), block.data(), count) != count) {
        throw Error(fmt::format("can't write {}: {}", path, sf_strerror(file.get())));
      }
    }
    if (sf_close(file.release()) != 0) throw Error(fmt::format("can't write {}: it could not be closed", path));
  });
}

}  // namespace kerf
