// Seal of a recording: a chain of digests over its blocks and, if the installation has a key, a signature at its end.
// docs/formats.md states what each of them proves.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// Digest of BLAKE2b with 256 bits.
using Digest = std::array<unsigned char, 32>;
Digest CalcDigest(std::string_view first, std::string_view rest = {});
std::string ToHex(const Digest& digest);

/// Public key of Ed25519, as 64 hexadecimal digits.
using PublicKey = std::string;
/// Returns the first 16 digits, for display.
std::string ShortKey(const PublicKey& key);

/// Secret key of Ed25519.
class SealKey {
 public:
  /// Creates a key from the system's random numbers.
  static SealKey Make();
  /// Parses the output of FormatSecret(). Throws kerf::Error if the text is not such a key.
  static SealKey ParseSecret(std::string_view text);
  std::string FormatSecret() const;
  PublicKey public_key() const;
  /// Signs a seal's digest. Returns 128 hexadecimal digits.
  std::string Sign(const Digest& digest) const;

 private:
  std::array<unsigned char, 32> seed_{};
};
/// Returns true if `signature` was made for this digest with the secret key that belongs to `key`. Returns false for an
/// invalid key or signature.
bool IsSignedBy(const Digest& digest, const PublicKey& key, std::string_view signature);

/// Last block of a recording.
struct SealBlock {
  Digest digest{};        // digest of the chain of all blocks before it
  PublicKey key;          // empty: not signed
  std::string signature;  // signature of `digest`
};
SealBlock MakeSeal(const Digest& digest, const std::optional<SealKey>& key);
std::string FormatSeal(const SealBlock& seal);
/// Throws kerf::Error if the text is not a seal.
SealBlock ParseSeal(const std::string& text);

/// Result of checking a recording's seal.
struct RecordingSeal {
  bool is_chained = false;  // written as version 2, with a digest in each block
  bool is_broken = false;   // a block or the seal was changed after writing
  bool is_whole = false;    // no block is missing, changed, added or moved, from the first block to the seal
  PublicKey signer;         // key of the valid signature; empty: none
};

/// A known public key and its owner.
struct KnownKey {
  PublicKey key;
  std::string owner;  // "this installation's", or the name that follows the key in a file
};
/// Returns a phrase such as "chain intact; signed by key 1234567890abcdef (this installation's)".
std::string DescribeSeal(const RecordingSeal& seal, const std::vector<KnownKey>& known);

// ---- Key of the installation.

/// Returns the path of the key file: $XDG_CONFIG_HOME/kerf/recording.key, otherwise ~/.config/kerf/recording.key.
/// Throws kerf::Error if neither XDG_CONFIG_HOME nor HOME is set.
std::string FindKeyFile();
/// Creates a key in that file, which only the user can read. Throws kerf::Error if the file exists already.
SealKey MakeKeyFile();
/// Reads the key from that file. Returns none if the file does not exist. Throws kerf::Error if other users can read
/// it, or if it is not a key.
std::optional<SealKey> ReadKeyFile();
/// Returns the public key of the installation for display, or none if there is no usable key.
std::vector<KnownKey> ListOwnKeys();
/// Returns a line that the user can pass on to others: "kerf public key 12ab...".
std::string FormatPublicKey(const PublicKey& key);
/// Reads lines in the format of FormatPublicKey(), each optionally followed by a name. Throws kerf::Error if a line is
/// invalid.
std::vector<KnownKey> ReadPublicKeys(const std::string& file);

}  // namespace kerf
