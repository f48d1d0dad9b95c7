// Sound files, through libsndfile.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace kerf {

/// A WAV file, one channel of 16 bit integers. `next` fills the vector, which it finds empty, with samples of -1 to 1
/// and says whether more will come; full scale is 32767. To a temporary beside `path`, then renamed. The same samples
/// give the same bytes. Throws Error when it can't be written or a sample is not within -1 to 1.
void WriteWav(const std::string& path, int rate_Hz, const std::function<bool(std::vector<float>&)>& next);

}  // namespace kerf
