// Adds an effect to kerf: it counts the turns during which the teeth cut, and slows the spindle down while they do.
//
//   own_effect SCENE
#include <cmath>
#include <cstdio>
#include <kerf/error.h>
#include <kerf/own_effect.h>
#include <kerf/run.h>

namespace {

class WornTeeth final : public kerf::OwnEffect {
 public:
  explicit WornTeeth(double slowdown) : slowdown_(slowdown) {}

  void Begin(kerf::EffectBegin& begin) noexcept override {
    if (cuts_) begin.rpm *= 1 - slowdown_;
  }
  void Solved(const kerf::OwnEffectStep& step) noexcept override {
    double teeth = 0;
    for (const kerf::ToothLoad& load : step.teeth) teeth += load.teeth;
    if (teeth > 0) turns_ += std::abs(step.rpm) / 60 * step.time_s;
  }
  void End(kerf::OwnEffectEnd& end) noexcept override { cuts_ = end.engaged_teeth > 0; }
  void Reset() noexcept override { cuts_ = false; }
  void Report(std::span<double> channels) const noexcept override { channels[0] = turns_; }

 private:
  double slowdown_;
  bool cuts_ = false;
  double turns_ = 0;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: own_effect SCENE\n");
    return 2;
  }
  kerf::EffectInfo info{
      .name = "worn_teeth",
      .summary = "counts the turns in bone and slows the spindle",
      .source = "an example",
      .reads = "teeth, spindle speed",
      .writes = "spindle speed",
      .state = "turns in bone",
      .sleeps = "no tooth cuts",
  };
  info.hooks = kerf::kEffectBegin | kerf::kEffectSolved | kerf::kEffectEnd;
  info.parameters = {{"slowdown", 0.1, 0, 1, "fraction of the speed that is lost while teeth cut"}};
  info.channels = {{"turns", "turns of the spindle while teeth cut"}};
  info.make_own = [](std::span<const kerf::EffectValue> values, const kerf::OwnEffectSetup&) {
    return std::unique_ptr<kerf::OwnEffect>(new WornTeeth(std::get<double>(values[0])));
  };
  kerf::RegisterEffect(info);

  const kerf::SceneFile scene = kerf::SceneFile::Read(argv[1]).With("effects.worn_teeth", "slowdown", "0.2");
  const kerf::PathRun run = kerf::RunAlongPath(scene);
  for (std::size_t i = 0; i < run.channels.names.size(); ++i) {
    std::printf("%s = %.6g at the end\n", run.channels.names[i].c_str(),
                run.channels.values[run.channels.values.size() - run.channels.names.size() + i]);
  }
} catch (const kerf::Error& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
