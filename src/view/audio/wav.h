// Sound files, through libsndfile.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kerf {

/// A WAV file that grows, one channel of 16 bit integers; full scale is 32767. To a temporary beside `path`, renamed by
/// Commit(). The same samples give the same bytes.
class WavFile {
 public:
  /// Throws Error when it can't be made.
  WavFile(const std::string& path, int rate_Hz);
  ~WavFile();
  WavFile(WavFile&&) noexcept;
  WavFile& operator=(WavFile&&) noexcept;

  /// Throws Error when it can't be written or a sample is not within -1 to 1.
  void Append(std::span<const float> samples);
  /// Throws Error. Once.
  void Commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same in one go. `next` fills the vector, which it finds empty, with samples of -1 to 1
/// and says whether more will come. Throws Error.
void WriteWav(const std::string& path, int rate_Hz, const std::function<bool(std::vector<float>&)>& next);

}  // namespace kerf
