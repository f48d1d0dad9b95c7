#include "session/effect_files.h"

#include "audio/wav.h"
#include "effects/plan.h"

namespace kerf {
namespace {

constexpr std::size_t kFramesAtOnce = 256;
constexpr float kFade_s = 0.01F;  // at the end: a tone that is cut off clicks

}  // namespace

EffectFiles::EffectFiles(const EffectPlan& plan, std::size_t ticks, bool here)
    : tone_(plan),
      spectrum_(here ? SpectrumTrack(plan) : SpectrumTrack()),
      guide_(plan, ticks),
      chips_(here ? ChipsTrack(plan) : ChipsTrack()),
      structures_(plan, ticks) {
  if (tone_.any()) tones_.reserve(ticks);
}

void EffectFiles::Take(double time_s, double dt_s, const Pose& X_WT, std::span<const double> channels) {
  if (tone_.any()) tones_.push_back(tone_.Read(dt_s, channels));
  spectrum_.Take(dt_s);
  guide_.Take(time_s, X_WT.p_AB, channels);
  chips_.Take(time_s, X_WT);
  structures_.Take(time_s, X_WT, channels);
}

std::vector<std::string> EffectFiles::WriteSounds(const std::string& folder) const {
  std::vector<std::string> written;
  if (!tones_.empty()) {
    WriteSound(folder + "/sound.wav");
    written.emplace_back("sound.wav");
  }
  return written;
}

std::vector<std::string> EffectFiles::WritePictures(const std::string& folder, const std::string& name,
                                                    const Bone& bone, const Tool& tool, bool patient) const {
  std::vector<std::string> written;
  if (WriteSpectrumPicture(spectrum_.CalcSpectrum(), name, folder + "/spectrum.png")) {
    written.emplace_back("spectrum.png");
  }
  if (!guide_.moments().empty()) {
    WriteGuidePicture(guide_, bone, tool, patient, name, folder + "/guide.png");
    WriteDeviationPlot(guide_, name, folder + "/deviation.png");
    written.insert(written.end(), {"guide.png", "deviation.png"});
  }
  if (WriteChipsPicture(chips_, bone, tool, patient, name, folder + "/chips.png")) written.emplace_back("chips.png");
  if (!structures_.moments().empty()) {
    WriteStructuresPicture(structures_, bone, tool, patient, name, folder + "/structures.png");
    written.emplace_back("structures.png");
  }
  return written;
}

const std::vector<std::string>& EffectFiles::Names() {
  static const std::vector<std::string> kNames{"sound.wav",     "spectrum.png", "guide.png",
                                               "deviation.png", "chips.png",    "structures.png"};
  return kNames;
}

void EffectFiles::WriteSound(const std::string& path) const {
  Tone tone(tone_.tone(), tone_.teeth());
  std::size_t done = 0;
  WriteWav(path, tone_.tone().rate_Hz, [&](std::vector<float>& samples) {
    for (std::size_t i = 0; i < kFramesAtOnce && done < tones_.size(); ++i) tone.Render(tones_[done++], samples);
    if (done < tones_.size()) return true;
    ToneFrame silence;
    silence.dt_s = kFade_s;
    silence.spindle_Hz = tones_.back().spindle_Hz;
    tone.Render(silence, samples);
    return false;
  });
}

}  // namespace kerf
