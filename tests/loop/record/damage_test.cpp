// Tests for reading damaged recordings and for checking the seal of a recording.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/compress/pack.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "support/folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kStepsInBlock = 10;  // a quarter of a second at 40 Hz

class DamagedRecordings : public ::testing::Test {
 protected:
  void SetUp() override { setenv("XDG_CONFIG_HOME", folder_.c_str(), 1); }

  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  static void WriteAll(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
  }
  /// Writes a recording that consists of two copies of its header, an input, four blocks of steps (an event follows the
  /// first, a piece the second), an end and a seal.
  std::string Record(const std::string& name, const std::optional<SealKey>& key = std::nullopt) const {
    RecordingHeader header;
    header.scene_toml = "x = 1\n";
    header.voxel_mm = 0.1;
    header.rate_hz = 40;
    fs::remove(Path(name));
    RecordingWriter writer(Path(name), header, {{"/a/path.csv", "1,2,3"}}, key);
    constexpr std::uint64_t kSteps = 4 * kStepsInBlock;
    for (std::uint64_t i = 0; i < kSteps; ++i) {
      if (i == kStepsInBlock) writer.AddEvent({0, 0, "checkpoint", "first", 1});
      if (i == 2 * kStepsInBlock) {
        writer.Flush();
        writer.AddPiece(1, "a piece");
      }
      RecordedStep step;
      step.X.p_AB = Vec3(static_cast<double>(i), 0, 0);
      step.dt_s = 0.025;
      if (i == 25) {
        step.flags = kRecordedPieceLeaves;
        step.piece = 1;
      }
      writer.Add(step, 0.025 * static_cast<double>(i + 1));
    }
    writer.Finish({kSteps, 0.025 * kSteps, 1, 2, 3, "asked"});
    return ReadTextFile(Path(name));
  }
  /// Returns the blocks of the file in order, preceded by its first line.
  std::vector<std::string> Split(const std::string& bytes) const {
    WriteAll(Path("split.kerf"), bytes);
    BlockReader reader(Path("split.kerf"));
    std::vector<std::string> parts{std::string(kRecordingMagic)};
    for (const BlockPlace& place : reader.places()) {
      parts.push_back(bytes.substr(place.offset - kBlockHeaderBytes, kBlockHeaderBytes + place.packed_bytes));
    }
    return parts;
  }
  static std::string Join(const std::vector<std::string>& parts) {
    std::string bytes;
    for (const std::string& part : parts) bytes += part;
    return bytes;
  }
  /// Makes an altered file consistent again, as a forger without the key could: recomputes each block's number and
  /// checksum and, if `chain` is true, its digest of the preceding block.
  static std::string Forge(std::vector<std::string> parts, bool chain) {
    BlockLink link = FirstLink();
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const std::string_view block = parts[i];
      BlockHeader header = ParseBlockHeader(block.substr(0, kBlockHeaderBytes));
      std::string bytes = Unpack(std::string(block.substr(kBlockHeaderBytes)), MaxUnpackedBytes(header.kind));
      if (chain && header.kind == BlockKind::kSeal) {
        SealBlock seal = ParseSeal(bytes);
        seal.digest = link.digest;
        bytes = FormatSeal(seal);
      }
      parts[i] = FormatBlock(header.kind, bytes, static_cast<std::uint32_t>(i - 1), chain ? &link : &header.before);
      link = LinkAfter(header.kind, parts[i], {});
    }
    return Join(parts);
  }
  RecordingReader Open(const std::string& bytes) const {
    WriteAll(Path("b.kerf"), bytes);
    return RecordingReader(Path("b.kerf"));
  }

  test::Folder own_;
  std::string folder_ = own_.path();
};

using Offsets = std::set<std::uint64_t>;

Offsets ReadableBlocks(const std::string& path) {
  BlockReader reader(path);
  Offsets offsets;
  for (const BlockPlace& place : reader.places()) offsets.insert(place.offset);
  return offsets;
}

// The format is redundant: one damaged bit costs at most the block that contains it.
TEST_F(DamagedRecordings, AnyFlippedBitIsDetectedAndCostsAtMostOneBlock) {
  const std::string bytes = Record("a.kerf");
  const Offsets all = ReadableBlocks(Path("a.kerf"));
  ASSERT_EQ(all.size(), 11u);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    // All blocks except the one that contains this byte; all of them for a byte of the first line.
    Offsets others = all;
    if (at >= kRecordingMagic.size()) {
      auto next = all.upper_bound(at + kBlockHeaderBytes);
      others.erase(*std::prev(next));
    }
    for (int bit = 0; bit < 8; ++bit) {
      std::string bad = bytes;
      bad[at] = static_cast<char>(bad[at] ^ (1 << bit));
      WriteAll(Path("b.kerf"), bad);
      ASSERT_EQ(ReadableBlocks(Path("b.kerf")), others) << "byte " << at << ", bit " << bit;
      if (static_cast<std::size_t>(bit) != at % 8) continue;  // limits the test's time
      RecordingReader reader(Path("b.kerf"));
      ASSERT_NE(reader.damage().state, RecordingState::kWhole) << "byte " << at << ", bit " << bit;
      ASSERT_NE(reader.DescribeDamage(), "");
      ASSERT_FALSE(reader.seal().is_whole);
      const std::uint64_t read = reader.steps();
      ASSERT_EQ(read + reader.damage().lost_steps, 40u) << "byte " << at << ", bit " << bit;
      ASSERT_GE(read, 30u);
    }
  }
}

TEST_F(DamagedRecordings, ReportsWhatIsMissing) {
  const std::vector<std::string> parts = Split(Record("a.kerf"));
  ASSERT_EQ(parts.size(), 12u);
  const auto spoil = [&](const std::set<std::size_t>& which) {
    std::vector<std::string> bad = parts;
    for (const std::size_t i : which) bad[i].back() = static_cast<char>(bad[i].back() ^ 1);
    return Open(Join(bad));
  };
  EXPECT_EQ(Open(Join(parts)).DescribeDamage(), "");
  EXPECT_EQ(Open(Join(parts)).damage().state, RecordingState::kWhole);

  const RecordingReader steps = spoil({6});
  EXPECT_EQ(steps.DescribeDamage(), "the steps from 0.250 to 0.500 s are damaged: 10 of 40 ticks");
  EXPECT_EQ(steps.damage().state, RecordingState::kDamaged);
  EXPECT_EQ(steps.damage().whole_steps, 10u);
  EXPECT_DOUBLE_EQ(steps.damage().whole_s, 0.25);
  EXPECT_EQ(steps.steps(), 30u);
  EXPECT_DOUBLE_EQ(steps.duration_s(), 1.0);
  ASSERT_TRUE(steps.end());

  EXPECT_EQ(spoil({4, 6, 9}).DescribeDamage(),
            "the steps from 0.000 to 0.500 s, from 0.750 to 1.000 s are damaged: 30 of 40 ticks");
  EXPECT_EQ(spoil({9}).damage().whole_steps, 30u);
  // Each block contains the kind of the preceding one.
  EXPECT_EQ(spoil({1}).DescribeDamage(), "one of the two copies of its header is damaged");
  EXPECT_EQ(spoil({2}).DescribeDamage(), "one of the two copies of its header is damaged");
  EXPECT_EQ(spoil({3}).DescribeDamage(), "an input of its scene is damaged");
  EXPECT_EQ(spoil({5}).DescribeDamage(), "an event is damaged");
  EXPECT_EQ(spoil({10}).DescribeDamage(),
            "the block that describes its end is damaged; its end after 1.000 s is missing");
  EXPECT_EQ(spoil({11}).DescribeDamage(), "its seal is damaged");
  EXPECT_EQ(spoil({11}).damage().state, RecordingState::kDamaged);
  EXPECT_EQ(spoil({6, 11}).DescribeDamage(),
            "the steps from 0.250 to 0.500 s are damaged: 10 of 40 ticks; its seal is damaged");
  EXPECT_THAT(spoil({10, 11}).DescribeDamage(), HasSubstr("bytes are damaged; its end after 1.000 s is missing"));
  const std::string whole = Join(parts);
  // Removes the last byte of the seal, all but one of its bytes, or all of it.
  for (const std::size_t left_out : {std::size_t{1}, parts.back().size() - 1, parts.back().size()}) {
    const RecordingReader unsealed = Open(whole.substr(0, whole.size() - left_out));
    EXPECT_EQ(unsealed.DescribeDamage(), "its seal is missing");
    EXPECT_EQ(unsealed.damage().state, RecordingState::kCutShort);
    EXPECT_FALSE(unsealed.seal().is_whole);
    EXPECT_EQ(unsealed.end()->why, "asked");
  }
  // Without the piece, the ticks after its removal cannot be replayed.
  const RecordingReader piece = spoil({7});
  EXPECT_EQ(piece.DescribeDamage(), "a piece of bone is damaged");
  EXPECT_EQ(piece.damage().whole_steps, 25u);
  EXPECT_THAT(test::MessageOf([&] { spoil({1, 2}); }), HasSubstr("damaged in its header"));

  // The recording is cut short at the end of a block, and within one.
  std::vector<std::string> cut(parts.begin(), parts.begin() + 9);
  EXPECT_EQ(Open(Join(cut)).DescribeDamage(), "cut short at 0.750 s: its end is missing");
  EXPECT_EQ(Open(Join(cut)).damage().state, RecordingState::kCutShort);
  cut.back().resize(cut.back().size() / 2);
  EXPECT_EQ(Open(Join(cut)).DescribeDamage(), "cut short at 0.500 s: its end is missing");
  EXPECT_EQ(Open(Join(cut)).damage().state, RecordingState::kCutShort);
  // Some bytes do not belong to a block.
  std::vector<std::string> more = parts;
  more[5] += std::string(100, 'x');
  EXPECT_EQ(Open(Join(more)).DescribeDamage(), "100 bytes in it do not belong to a block");
}

// A forger with knowledge of the format can write any block with a valid checksum; the chain reveals it.
TEST_F(DamagedRecordings, ForgedBlockBreaksTheChain) {
  const SealKey key = SealKey::Make();
  const std::vector<std::string> parts = Split(Record("a.kerf", key));
  EXPECT_TRUE(Open(Forge(parts, false)).seal().is_whole) << "forging changes nothing by itself";

  const auto expect_seen = [&](const std::vector<std::string>& forged, const std::string& what) {
    const RecordingReader reader = Open(Forge(forged, false));
    EXPECT_EQ(reader.damage().state, RecordingState::kDamaged) << what;
    EXPECT_FALSE(reader.seal().is_whole) << what;
    EXPECT_EQ(reader.seal().signer, "") << what;
    EXPECT_THAT(reader.DescribeDamage(), HasSubstr("chain is broken")) << what;
  };
  const auto remake = [&](std::size_t i, const std::string& bytes) {
    const BlockHeader header = ParseBlockHeader(std::string_view(parts[i]).substr(0, kBlockHeaderBytes));
    return FormatBlock(header.kind, bytes, header.number, &header.before);
  };
  std::vector<std::string> changed = parts;
  changed[5] = remake(5, R"({"step":10,"time_s":0.25,"what":"checkpoint","name":"other","number":1})");
  expect_seen(changed, "changed");
  std::vector<std::string> removed = parts;
  removed.erase(removed.begin() + 5);
  expect_seen(removed, "removed");
  std::vector<std::string> swapped = parts;
  std::swap(swapped[3], swapped[5]);
  expect_seen(swapped, "swapped");
  std::vector<std::string> added = parts;
  added.insert(added.begin() + 5, parts[5]);
  expect_seen(added, "added");
}

TEST_F(DamagedRecordings, RecomputedChainIsDetectedOnlyByTheSignature) {
  const SealKey key = SealKey::Make();
  const std::string bytes = Record("a.kerf", key);
  EXPECT_EQ(Open(bytes).seal().signer, key.public_key());
  std::vector<std::string> parts = Split(bytes);
  parts.erase(parts.begin() + 5);  // removes the event
  // The original signature is kept, but it belongs to a different digest.
  const RecordingReader kept = Open(Forge(parts, true));
  EXPECT_EQ(kept.damage().state, RecordingState::kDamaged);
  EXPECT_THAT(kept.DescribeDamage(), HasSubstr("signature does not match"));
  EXPECT_EQ(kept.seal().signer, "");
  // Without the signature, it is a complete recording that is not signed.
  const BlockHeader header = ParseBlockHeader(std::string_view(parts.back()).substr(0, kBlockHeaderBytes));
  parts.back() = FormatBlock(BlockKind::kSeal, FormatSeal({}), header.number, &header.before);
  const RecordingReader unsigned_one = Open(Forge(parts, true));
  EXPECT_EQ(unsigned_one.damage().state, RecordingState::kWhole);
  EXPECT_TRUE(unsigned_one.seal().is_whole);
  EXPECT_EQ(unsigned_one.seal().signer, "");
  // A recording without its seal counts as cut short.
  parts.pop_back();
  EXPECT_EQ(Open(Forge(parts, true)).damage().state, RecordingState::kCutShort);
  // No block may follow the seal.
  std::vector<std::string> longer = Split(bytes);
  longer.push_back(longer[5]);
  EXPECT_THAT(Open(Forge(longer, true)).DescribeDamage(), HasSubstr("after its end"));
}

TEST_F(DamagedRecordings, ReportsTheOwnerOfTheSeal) {
  const SealKey key = SealKey::Make();
  Record("signed.kerf", key);
  Record("unsigned.kerf");
  const auto describe = [&](const std::string& name, const std::vector<KnownKey>& known) {
    return DescribeSeal(RecordingReader(Path(name)).seal(), known);
  };
  const std::string shown = "chain intact; signed by key " + key.public_key().substr(0, 16);
  EXPECT_EQ(describe("signed.kerf", {}), shown + " (owner unknown)");
  EXPECT_EQ(describe("signed.kerf", {{key.public_key(), "this installation's"}}), shown + " (this installation's)");
  EXPECT_EQ(describe("unsigned.kerf", {}), "chain intact; not signed");
}

// The expected digest of "abc" is that of RFC 7693 with a length of 256 bits, as printed by b2sum -l 256.
TEST_F(DamagedRecordings, TheDigestIsBlake2b) {
  const std::string abc = "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319";
  EXPECT_EQ(ToHex(CalcDigest("abc")), abc);
  EXPECT_EQ(ToHex(CalcDigest("a", "bc")), abc);
}

TEST_F(DamagedRecordings, KeyFileIsPrivateAndNeverReplaced) {
  EXPECT_FALSE(ReadKeyFile());
  const SealKey made = MakeKeyFile();
  const std::string path = Path("kerf/recording.key");
  EXPECT_EQ(FindKeyFile(), path);
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0600u);
  ASSERT_TRUE(ReadKeyFile());
  EXPECT_EQ(ReadKeyFile()->public_key(), made.public_key());
  EXPECT_THAT(test::MessageOf([] { MakeKeyFile(); }), HasSubstr("never replaced"));
  EXPECT_EQ(ReadKeyFile()->public_key(), made.public_key());

  const Digest digest = CalcDigest("abc");
  EXPECT_TRUE(IsSignedBy(digest, made.public_key(), made.Sign(digest)));
  EXPECT_FALSE(IsSignedBy(CalcDigest("abd"), made.public_key(), made.Sign(digest)));
  EXPECT_FALSE(IsSignedBy(digest, SealKey::Make().public_key(), made.Sign(digest)));
  EXPECT_FALSE(IsSignedBy(digest, "", ""));

  ASSERT_EQ(chmod(path.c_str(), 0644), 0);
  EXPECT_THAT(test::MessageOf([] { ReadKeyFile(); }), HasSubstr("accessible to other users"));
  ASSERT_EQ(chmod(path.c_str(), 0600), 0);
  WriteAll(path, "nonsense");
  EXPECT_THAT(test::MessageOf([] { ReadKeyFile(); }), HasSubstr("is not a kerf secret key"));
  // If there is a symbolic link in the file's place, it is not followed.
  fs::remove(path);
  WriteAll(Path("mine"), "mine");
  fs::create_symlink(Path("mine"), path);
  EXPECT_THAT(test::MessageOf([] { MakeKeyFile(); }), HasSubstr("already exists"));
  EXPECT_EQ(ReadTextFile(Path("mine")), "mine");
}

TEST_F(DamagedRecordings, PublicKeyFilesAreReadOrRefused) {
  const std::string key = SealKey::Make().public_key();
  WriteAll(Path("keys"), "# class\n" + FormatPublicKey(key) + " room 3\n\n" + FormatPublicKey(key) + "\n");
  const std::vector<KnownKey> keys = ReadPublicKeys(Path("keys"));
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].key, key);
  EXPECT_EQ(keys[0].owner, "room 3, in " + Path("keys"));
  for (const std::string& bad :
       {key, std::string("kerf public key 12"), FormatPublicKey(key) + "0", "kerf secret key " + key}) {
    WriteAll(Path("keys"), bad);
    EXPECT_THAT(test::MessageOf([&] { ReadPublicKeys(Path("keys")); }), HasSubstr("line 1 is not")) << bad;
  }
  WriteAll(Path("keys"), "\n");
  EXPECT_THAT(test::MessageOf([&] { ReadPublicKeys(Path("keys")); }), HasSubstr("contains no public key"));
}

}  // namespace
}  // namespace kerf
