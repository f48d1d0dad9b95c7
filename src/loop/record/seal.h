// The seal of a recording: a chain of digests over its blocks and, with a key of the installation, a signature at its
// end. docs/formats.md says what each of them shows and what not.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// BLAKE2b with 256 bits.
using Digest = std::array<unsigned char, 32>;
Digest CalcDigest(std::string_view first, std::string_view rest = {});
std::string ToHex(const Digest& digest);

/// 64 hexadecimal digits.
using PublicKey = std::string;
/// Its first 16 digits, for people.
std::string ShortKey(const PublicKey& key);

/// A secret key of Ed25519.
class SealKey {
 public:
  /// A fresh one, from the system's random numbers.
  static SealKey Make();
  /// As FormatSecret() gave it. Throws Error.
  static SealKey ParseSecret(std::string_view text);
  std::string FormatSecret() const;
  PublicKey public_key() const;
  /// Of a seal's digest: 128 hexadecimal digits.
  std::string Sign(const Digest& digest) const;

 private:
  std::array<unsigned char, 32> seed_{};
};
/// False also for a key or signature that is none.
bool IsSignedBy(const Digest& digest, const PublicKey& key, std::string_view signature);

/// The block at the end of a recording.
struct SealBlock {
  Digest digest{};        // of all blocks before it, by the chain
  PublicKey key;          // empty: not signed
  std::string signature;  // of `digest`
};
SealBlock MakeSeal(const Digest& digest, const std::optional<SealKey>& key);
std::string FormatSeal(const SealBlock& seal);
/// Throws Error.
SealBlock ParseSeal(const std::string& text);

/// What the seal of a recording shows.
struct RecordingSeal {
  bool is_chained = false;  // written as version 2, with a digest in each block
  bool is_broken = false;   // a block or the seal is not the one that was written
  bool is_whole = false;    // no block is missing, changed, added or in another place, from the first to the seal
  PublicKey signer;         // whose signature is good; empty: none
};

/// A public key that is known, and whose it is.
struct KnownKey {
  PublicKey key;
  std::string owner;  // "this installation", or what stands behind it in a file
};
/// "chain whole; signed by key 1234567890abcdef (this installation's)".
std::string DescribeSeal(const RecordingSeal& seal, const std::vector<KnownKey>& known);

// ---- the key of the installation

/// $XDG_CONFIG_HOME/kerf/recording.key, else ~/.config/kerf/recording.key. Throws Error when neither is set.
std::string FindKeyFile();
/// Makes a key there, which only the user can read. Throws Error when there is one already.
SealKey MakeKeyFile();
/// None when there is no such file. Throws Error when others can read it, or it is not a key.
std::optional<SealKey> ReadKeyFile();
/// Its public half, or none when there is no key that can be used: for showing what is known.
std::vector<KnownKey> ListOwnKeys();
/// One line for other people: "kerf public key 12ab...".
std::string FormatPublicKey(const PublicKey& key);
/// Lines as FormatPublicKey() gives, each with a name behind it or without. Throws Error.
std::vector<KnownKey> ReadPublicKeys(const std::string& file);

}  // namespace kerf
