#include "session/project/project.h"
#include "session/project/project_texts.h"
#include "target.h"

namespace kerf::fuzz {

/// The archive with its directory and manifest, all members unpacked, and the texts that have no target of their own.
KERF_FUZZ_TARGET(project) {
  const std::string path = "fuzz.kerf-project";
  Accepts([&] {
    const ZipReader zip(bytes, path);
    for (std::size_t i = 0; i < zip.members().size(); ++i) {
      Accepts([&] {
        std::uint64_t size = 0;
        zip.Unpack(i, [&](std::string_view block) { size += block.size(); });
        if (size != zip.members()[i].bytes) Finding("a member has another size than its header states");
      });
    }
    const project_detail::ProjectTexts texts = project_detail::ReadProjectTexts(zip, path);
    Accepts([&] { project_detail::ParseSettings(texts.Get("settings.json"), path); });
    Accepts([&] { ParseViews(texts.Get("views.json"), path); });
    Accepts([&] { ParseSessions(texts.Get("sessions.json"), path); });
    Accepts([&] {
      CheckMeasuredPoints(ParseMeasuredPoints(texts.Get("measurements.json"), path), texts.Get("pieces.json"), path);
    });
  });
  const std::string text(bytes);
  Accepts([&] { ParseViews(FormatViews(ParseViews(text, path)), path); });
  Accepts([&] { ParseSessions(FormatSessions(ParseSessions(text, path)), path); });
  Accepts([&] {
    const std::vector<MeasuredPoints> measurements = ParseMeasuredPoints(text, path);
    if (ParseMeasuredPoints(FormatMeasuredPoints(measurements), path) != measurements) {
      Finding("measurements are others after writing and reading");
    }
  });
}

}  // namespace kerf::fuzz
