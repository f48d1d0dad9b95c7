// Sound files, written with libsndfile.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kerf {

/// Incrementally written WAV file: one channel of 16-bit integers, full scale 32767. Writes to a temporary file next to
/// `path`, which Commit() renames. Equal samples give equal bytes.
class WavFile {
 public:
  /// Throws Error if the file cannot be created.
  WavFile(const std::string& path, int rate_Hz);
  ~WavFile();
  WavFile(WavFile&&) noexcept;
  WavFile& operator=(WavFile&&) noexcept;

  /// Throws Error if the file cannot be written or a sample is outside -1 to 1.
  void Append(std::span<const float> samples);
  /// Finishes the file and renames it. Must be called at most once. Throws Error on failure.
  void Commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes a whole WAV file. `next` fills the empty vector passed to it with samples from -1 to 1 and returns true if
/// more follow. Throws Error as WavFile does.
void WriteWav(const std::string& path, int rate_Hz, const std::function<bool(std::vector<float>&)>& next);

}  // namespace kerf
