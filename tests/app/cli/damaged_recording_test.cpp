// Tests of the commands' messages and exit codes for recordings that are damaged, truncated, forged or signed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/files/markdown_text.h"
#include "support/block_scene.h"
#include "support/forge_recording.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::MakeBlockScene;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;
using testing::StartsWith;

class DamagedRecordingCommands : public test::ProgramTest {
 protected:
  DamagedRecordingCommands() : ProgramTest({{"s.toml", MakeBlockScene()}}) {}
  ProgramResult Run(const std::string& arguments) const { return KerfWithin("XDG_CONFIG_HOME=$PWD/config", arguments); }
  void Record(const std::string& name = "a.kerf") const {
    const ProgramResult made =
        Run("loop s.toml --virtual --seconds 2 --do 0.6:checkpoint=first --do 1.6:undo=first --record " + name);
    ASSERT_EQ(made.code, 0) << made.err;
  }
  /// Writes bad.kerf with one bit flipped in the block of steps that begins at `first_step`.
  void Damage(std::uint64_t first_step) const {
    std::string bytes = Slurp(folder_ / "a.kerf");
    BlockReader blocks((folder_ / "a.kerf").string());
    bool found = false;
    for (const BlockPlace& place : blocks.places()) {
      if (place.kind != BlockKind::kSteps || DecodeBlock(blocks.Read(place)).first_step != first_step) continue;
      bytes[place.offset + 5] = static_cast<char>(bytes[place.offset + 5] ^ 16);
      found = true;
    }
    ASSERT_TRUE(found);
    Write("bad.kerf", bytes);
  }
  static std::vector<std::string> Lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
};

TEST_F(DamagedRecordingCommands, GapIsNamedAndEverythingElseIsShown) {
  Record();
  Damage(850);
  const std::string sentence = "the steps from 0.850 to 1.100 s are damaged: 250 of 2000 ticks";
  // The recording is replayed up to the gap, and the results are written.
  const ProgramResult replayed = Run("replay bad.kerf --verify --json -o out");
  EXPECT_EQ(replayed.code, 3);
  EXPECT_THAT(replayed.err, HasSubstr("bad.kerf: " + sentence));
  EXPECT_THAT(replayed.err, HasSubstr("the replay ends at 0.850 s"));
  const auto json = nlohmann::json::parse(replayed.out);
  EXPECT_EQ(json.at("state"), "damaged");
  EXPECT_EQ(json.at("damage"), sentence);
  EXPECT_EQ(json.at("lost_ticks"), 250);
  EXPECT_EQ(json.at("replayed_ticks"), 850);
  EXPECT_TRUE(json.at("identical"));
  EXPECT_TRUE(Exists("out/forces.csv"));
  EXPECT_EQ(Run("replay bad.kerf").code, 3);
  EXPECT_EQ(Run("replay bad.kerf --until 0.5").code, 3);
  const ProgramResult beyond = Run("replay bad.kerf --until 1.5");
  EXPECT_EQ(beyond.code, 1);
  EXPECT_THAT(beyond.err, HasSubstr("up to 0.850 s"));

  // The part after the gap is read: the event, and the rows with their correct times.
  const ProgramResult shown = Run("log bad.kerf");
  EXPECT_EQ(shown.code, 3);
  EXPECT_THAT(shown.out, HasSubstr("1.600 s: undo first"));
  EXPECT_THAT(shown.out, HasSubstr(sentence));
  const ProgramResult whole_csv = Run("log a.kerf --csv");
  const ProgramResult csv = Run("log bad.kerf --csv");
  EXPECT_EQ(whole_csv.code, 0);
  EXPECT_EQ(csv.code, 3);
  std::vector<std::string> expected = Lines(whole_csv.out);
  ASSERT_EQ(expected.size(), 201u);
  expected.erase(expected.begin() + 1 + 85, expected.begin() + 1 + 110);
  EXPECT_EQ(Lines(csv.out), expected);
  std::vector<std::string> ticks = Lines(Run("log a.kerf --csv --ticks").out);
  ticks.erase(ticks.begin() + 1 + 850, ticks.begin() + 1 + 1100);
  EXPECT_EQ(Run("log bad.kerf --csv --ticks -o ticks.csv").code, 3);
  EXPECT_EQ(Lines(Slurp(folder_ / "ticks.csv")), ticks);
  const auto gaps = nlohmann::json::parse(Run("log bad.kerf --json").out).at("lost").at("gaps");
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].at("first_step"), 850);

  EXPECT_EQ(Run("score a.kerf --json").code, 0);
  const ProgramResult scored = Run("score bad.kerf --json");
  EXPECT_EQ(scored.code, 3);
  EXPECT_TRUE(nlohmann::json::accept(scored.out));

  // A session continues only from before the gap, and only if --at requests it.
  const ProgramResult from_end = Run("loop --from bad.kerf --virtual --seconds 0.2");
  EXPECT_EQ(from_end.code, 1);
  EXPECT_THAT(from_end.err, HasSubstr("up to 0.850 s, with --at"));
  EXPECT_EQ(Run("loop --from bad.kerf --at 0.8 --virtual --seconds 0.2 --record on.kerf").code, 0);
  EXPECT_EQ(Run("replay on.kerf --verify").code, 0);
}

// Warnings about a damaged recording that are printed on stderr are also in every file and page made from it.
TEST_F(DamagedRecordingCommands, PagesFromADamagedRecordingStateTheDamage) {
  Record();
  Damage(850);
  const std::string bytes = Slurp(folder_ / "a.kerf");
  Write("short.kerf", bytes.substr(0, bytes.size() / 2));
  const struct {
    const char* file;
    const char* state;
    const char* sentence;
    std::size_t warnings;
  } cases[] = {{"bad", "damaged", "the steps from 0.850 to 1.100 s are damaged: 250 of 2000 ticks", 2},
               {"short", "cut short", "cut short at ", 1}};
  for (const auto& [file, state, sentence, count] : cases) {
    const std::string name = file;
    const ProgramResult assessed = Run(fmt::format("assess {0}.kerf --no-pictures -o {0}_assessed", name));
    EXPECT_EQ(assessed.code, 3);
    EXPECT_THAT(assessed.out, HasSubstr(sentence));
    EXPECT_THAT(Slurp(folder_ / (name + "_assessed/report.html")), HasSubstr(sentence));
    const auto assessment = nlohmann::json::parse(Slurp(folder_ / (name + "_assessed/assessment.json")));
    EXPECT_EQ(assessment.at("recording_state"), state);
    EXPECT_EQ(assessment.at("warnings").size(), count);
    const ProgramResult replayed = Run(fmt::format("replay {0}.kerf -o {0}_replayed", name));
    EXPECT_EQ(replayed.code, 3);
    EXPECT_THAT(replayed.out, HasSubstr(sentence));
    EXPECT_THAT(Slurp(folder_ / (name + "_replayed/report.md")), HasSubstr(EscapeMarkdown(sentence)));
    const auto loop = nlohmann::json::parse(Slurp(folder_ / (name + "_replayed/loop.json")));
    // Each sentence is in the file and on stderr.
    for (std::size_t i = 0; i < count; ++i) {
      const std::string warning = assessment["warnings"][i];
      EXPECT_EQ(loop.at("warnings").at(i), warning);
      EXPECT_THAT(assessed.err, HasSubstr(fmt::format("{}.kerf: {}\n", name, warning)));
      EXPECT_THAT(replayed.err, HasSubstr(fmt::format("{}.kerf: {}\n", name, warning)));
    }
    EXPECT_THAT(assessment["warnings"][0].get<std::string>(), StartsWith(sentence));
  }
  // A complete recording causes no such warning.
  const auto whole = nlohmann::json::parse(Run("assess a.kerf --json").out);
  EXPECT_EQ(whole.at("recording_state"), "whole");
  EXPECT_TRUE(whole.at("warnings").empty());
}

TEST_F(DamagedRecordingCommands, RunAlongAPathReportsTheDamageInItsSummary) {
  ASSERT_EQ(Run("run s.toml -o out --record a.kerf").code, 0);
  const std::string bytes = Slurp(folder_ / "a.kerf");
  Write("short.kerf", bytes.substr(0, bytes.size() / 2));
  EXPECT_EQ(Run("replay short.kerf -o again").code, 3);
  const auto json = nlohmann::json::parse(Slurp(folder_ / "again/summary.json"));
  ASSERT_FALSE(json.at("warnings").empty());
  EXPECT_THAT(json["warnings"][0].get<std::string>(), StartsWith("cut short at "));
}

TEST_F(DamagedRecordingCommands, AKilledSessionIsCutShort) {
  // The program is killed as soon as some blocks are written, however slow the machine is.
  const std::string script = "cd '" + folder_.string() +
                             "' && { '" KERF_PROGRAM
                             "' loop s.toml --seconds 600 --record a.kerf >live.txt 2>&1 & "
                             "for i in $(seq 600); do [ \"$(stat -c %s a.kerf 2>/dev/null || echo 0)\" -gt 9000 ] && "
                             "break; sleep 0.1; done; kill -KILL $!; wait; } 2>/dev/null";
  ASSERT_NE(std::system(script.c_str()), -1);
  const ProgramResult replayed = Run("replay a.kerf --verify");
  EXPECT_EQ(replayed.code, 3);
  EXPECT_THAT(replayed.err, HasSubstr("cut short at "));
  EXPECT_THAT(replayed.out, HasSubstr("bit-identical to the recording"));
  const ProgramResult shown = Run("log a.kerf");
  EXPECT_EQ(shown.code, 3);
  EXPECT_THAT(shown.out, HasSubstr("cut short at "));
  EXPECT_EQ(Run("log a.kerf --csv").code, 3);
  EXPECT_EQ(Run("score a.kerf").code, 3);
  // A recording that continues the damaged one is complete.
  EXPECT_EQ(Run("loop --from a.kerf --virtual --seconds 0.2 --record on.kerf").code, 0);
  EXPECT_EQ(Run("replay on.kerf --verify").code, 0);
}

TEST_F(DamagedRecordingCommands, AnAlteredRowOrEventFailsTheVerification) {
  Record();
  const std::string from = (folder_ / "a.kerf").string();
  test::ForgeSteps(from, (folder_ / "row.kerf").string(), [](RecordedBlock& block) {
    for (RecordedState& state : block.states) {
      if (state.step == 1209) state.f_N.z += 0.001;
    }
  });
  const ProgramResult row = Run("replay row.kerf --verify");
  EXPECT_EQ(row.code, 1);
  EXPECT_THAT(row.err,
              HasSubstr("from tick 1210 on, at 1.210 s: the row of states of 1.210 s: force_z_N was recorded"));
  EXPECT_EQ(Run("replay row.kerf").code, 0) << "without --verify it warns";
  test::ForgeRecording(from, (folder_ / "event.kerf").string(), [](BlockKind kind, std::string& bytes) {
    const std::size_t at = bytes.find(R"("name":"first")");
    if (kind == BlockKind::kEvent && bytes.find("undo") == std::string::npos)
      bytes.replace(at, 14, R"("name":"other")");
  });
  const ProgramResult event = Run("replay event.kerf --verify");
  EXPECT_EQ(event.code, 1);
  EXPECT_THAT(event.err, HasSubstr("the event \"undo first\" at 1.600 s"));
  // The recording is damaged, and the replay differs from the recorded run. The difference determines the exit code.
  std::string bytes = Slurp(folder_ / "row.kerf");
  Write("both.kerf", bytes.substr(0, bytes.size() - 40));
  EXPECT_EQ(Run("replay both.kerf --verify").code, 1);
}

TEST_F(DamagedRecordingCommands, KeySignsLaterRecordings) {
  Record("unsigned.kerf");
  EXPECT_THAT(Run("log unsigned.kerf").out, HasSubstr("chain intact; not signed"));
  const ProgramResult none = Run("log --show-key");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("there is no key; 'kerf log --make-key' makes one"));
  const ProgramResult made = Run("log --make-key");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, StartsWith("kerf public key "));
  EXPECT_EQ(Run("log --make-key").code, 1);
  EXPECT_EQ(Run("log --show-key").out, made.out);

  Record();
  const std::string short_key = made.out.substr(16, 16);
  EXPECT_THAT(Run("log a.kerf").out, HasSubstr("signed by key " + short_key + " (this installation's)"));
  EXPECT_THAT(Kerf("log a.kerf").out, HasSubstr("signed by key " + short_key + " (owner unknown)"));
  EXPECT_EQ(nlohmann::json::parse(Run("log a.kerf --json").out).at("seal").at("signer"), made.out.substr(16, 64));
  Write("keys", made.out.substr(0, 80) + " room 3\n");
  const ProgramResult known = KerfWithin("XDG_CONFIG_HOME=$PWD/elsewhere", "log a.kerf --key keys");
  EXPECT_EQ(known.code, 0) << known.err;
  EXPECT_THAT(known.out, HasSubstr("(room 3, in keys)"));
  for (const char* other : {"unsigned.kerf", "forged.kerf"}) {
    if (!Exists(other)) {
      test::ForgeRecording((folder_ / "a.kerf").string(), (folder_ / other).string(), [](BlockKind, std::string&) {});
    }
    const ProgramResult refused = Run(std::string("log --key keys ") + other);
    EXPECT_EQ(refused.code, 1) << other;
    EXPECT_THAT(refused.err, HasSubstr("is not signed by a key in keys"));
  }
  EXPECT_EQ(Run("log a.kerf --key s.toml").code, 1);
  EXPECT_EQ(Run("log a.kerf --make-key").code, 2);
  EXPECT_EQ(Run("log").code, 2);
}

// A block of steps is replaced, with a correct checksum. This breaks the chain, but the readable part is still shown.
TEST_F(DamagedRecordingCommands, ABrokenChainIsDamage) {
  Record();
  std::string bytes = Slurp(folder_ / "a.kerf");
  BlockReader blocks((folder_ / "a.kerf").string());
  for (const BlockPlace& place : blocks.places()) {
    if (place.kind != BlockKind::kEvent) continue;
    const std::size_t from = place.offset - kBlockHeaderBytes;
    const BlockHeader header = ParseBlockHeader(std::string_view(bytes).substr(from, kBlockHeaderBytes));
    std::string event = blocks.Read(place);
    event.replace(event.find("first"), 5, "other");
    bytes.replace(from, kBlockHeaderBytes + place.packed_bytes,
                  FormatBlock(header.kind, event, header.number, &header.before));
    break;
  }
  Write("bad.kerf", bytes);
  const ProgramResult shown = Run("log bad.kerf");
  EXPECT_EQ(shown.code, 3);
  EXPECT_THAT(shown.out, HasSubstr("checkpoint other"));
  EXPECT_THAT(shown.out, HasSubstr("chain is broken"));
}

}  // namespace
}  // namespace kerf
