// Tests that another program reads the samples that were written.
#include "view/audio/wav.h"

#include <gtest/gtest.h>
#include <sndfile.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>

#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

class Wav : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (fs::temp_directory_path() / ("kerf_wav_" + std::to_string(getpid()))).string();
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string At(const char* name) const { return folder_ + "/" + name; }
  std::string folder_;
};

/// Returns a function that delivers `all` in blocks of `size`.
std::function<bool(std::vector<float>&)> InBlocks(const std::vector<float>& all, std::size_t size) {
  return [&all, size, done = std::size_t{0}](std::vector<float>& samples) mutable {
    while (samples.size() < size && done < all.size()) samples.push_back(all[done++]);
    return done < all.size();
  };
}

TEST_F(Wav, RoundTripsHeaderAndSamples) {
  std::vector<float> all;
  for (int i = 0; i < 10'001; ++i) all.push_back(static_cast<float>(std::sin(0.1 * i)));
  all.push_back(1);
  all.push_back(-1);
  WriteWav(At("a.wav"), 48000, InBlocks(all, 37));
  SF_INFO info{};
  SNDFILE* file = sf_open(At("a.wav").c_str(), SFM_READ, &info);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(info.frames, 10'003);
  EXPECT_EQ(info.samplerate, 48000);
  EXPECT_EQ(info.channels, 1);
  EXPECT_EQ(info.format, SF_FORMAT_WAV | SF_FORMAT_PCM_16);
  std::vector<std::int16_t> read(all.size());
  ASSERT_EQ(sf_read_short(file, read.data(), 10'003), 10'003);
  sf_close(file);
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_NEAR(read[i], 32767.0 * static_cast<double>(all[i]), 0.5) << i;  // half of the last bit
  }
}

TEST_F(Wav, BytesAreIndependentOfTheBlocks) {
  std::vector<float> all;
  for (int i = 0; i < 5000; ++i) all.push_back(static_cast<float>(0.5 * std::cos(0.01 * i)));
  WriteWav(At("a.wav"), 44100, InBlocks(all, 1));
  WriteWav(At("b.wav"), 44100, InBlocks(all, 5000));
  EXPECT_EQ(ReadTextFile(At("a.wav")), ReadTextFile(At("b.wav")));
}

TEST_F(Wav, IsCompleteOrAbsent) {
  WriteWav(At("a.wav"), 8000, InBlocks({0.25F, 0.5F}, 8));
  const std::string before = ReadTextFile(At("a.wav"));
  // The second block is too loud. The previous file is kept, and there is no other file.
  EXPECT_THROW(WriteWav(At("a.wav"), 8000, InBlocks({0, 0, 0, 1.5F}, 2)), Error);
  EXPECT_THROW(WriteWav(At("a.wav"), 8000, InBlocks({NAN}, 2)), Error);
  EXPECT_EQ(ReadTextFile(At("a.wav")), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
  EXPECT_THROW(WriteWav(At("none/a.wav"), 8000, InBlocks({0}, 2)), Error);
  // Without samples, the result is a valid empty file.
  WriteWav(At("empty.wav"), 8000, [](std::vector<float>&) { return false; });
  SF_INFO info{};
  SNDFILE* file = sf_open(At("empty.wav").c_str(), SFM_READ, &info);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(info.frames, 0);
  sf_close(file);
}

}  // namespace
}  // namespace kerf
