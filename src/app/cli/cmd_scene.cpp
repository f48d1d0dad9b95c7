// kerf scene: prints the default scene, or a scene with all its values.
#include <cstdio>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "base/files/files.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

struct SceneArguments {
  std::string file;
  std::string output;
  bool defaults = false;
};

void Run(const SceneArguments& options) {
  if (options.defaults == !options.file.empty()) {
    throw CLI::ValidationError("scene", "give either FILE or --defaults");
  }
  CheckInputsNotOverwritten({options.file}, {options.output});
  const std::string text = options.defaults ? DefaultSceneToml() : ResolvedToml(ReadScene(options.file));
  if (options.output.empty()) {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else {
    WriteTextFile(options.output, text);
  }
}

}  // namespace

void AddSceneCommand(CLI::App& app) {
  const auto options = std::make_shared<SceneArguments>();
  CLI::App* command = app.add_subcommand("scene", "Print a scene as commented TOML with every value, unit and range");
  command->add_option("FILE", options->file, "Scene file (TOML), printed with all its values, given or default");
  command->add_flag("--defaults", options->defaults,
                    "Print the default scene instead, with all keys of a scene; it can be run as it is");
  command->add_option("-o,--output", options->output, "File for the output; default: stdout");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
