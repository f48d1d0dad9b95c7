#include "session/run/effect_files.h"

#include "cut/effects/plan.h"

namespace kerf {
EffectFiles::EffectFiles(const EffectPlan& plan, std::size_t ticks, bool in_tick_thread, const std::string& folder)
    : sound_(plan, ticks, folder.empty() ? "" : folder + "/sound.wav"),
      spectrum_(in_tick_thread ? SpectrumTrack(plan) : SpectrumTrack()),
      guide_(plan, ticks),
      chips_(in_tick_thread ? ChipsTrack(plan) : ChipsTrack()),
      structures_(plan, ticks) {}

void EffectFiles::Take(double time_s, double dt_s, const Pose& X_WT, std::span<const double> channels) {
  sound_.Take(dt_s, channels);
  spectrum_.Take(dt_s);
  guide_.Take(time_s, X_WT.p_AB, channels);
  chips_.Take(time_s, X_WT);
  structures_.Take(time_s, X_WT, channels);
}

std::vector<std::string> EffectFiles::WriteSounds(const std::string& folder) {
  std::vector<std::string> written;
  if (sound_.Write(folder + "/sound.wav")) written.emplace_back("sound.wav");
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

}  // namespace kerf
