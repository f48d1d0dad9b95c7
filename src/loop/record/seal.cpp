#include "loop/record/seal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/core/errno_text.h"
#include "base/files/files.h"
#include "base/files/user_folders.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::string_view kSecretPrefix = "kerf secret key ";
constexpr std::string_view kPublicPrefix = "kerf public key ";
// Precedes the digest, so that a signature of other data is not valid here.
constexpr std::string_view kSignaturePrefix = "kerf recording seal 1\n";
constexpr std::size_t kMaxKeyBytes = std::size_t{1} << 20;
constexpr mode_t kOthers = S_IRWXG | S_IRWXO;

using Signature = std::array<unsigned char, crypto_sign_BYTES>;
using Secret = std::array<unsigned char, crypto_sign_SECRETKEYBYTES>;

/// Initialises libsodium, which is necessary before it is used.
void InitSodium() {
  static const int begun = sodium_init();
  if (begun < 0) throw Error("libsodium can't be used here: the system provides no random numbers");
}

template <std::size_t kSize>
std::string Hex(const std::array<unsigned char, kSize>& bytes) {
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

template <std::size_t kSize>
bool ParseHex(std::string_view text, std::array<unsigned char, kSize>& bytes) {
  if (text.size() != 2 * kSize || text.find_first_not_of("0123456789abcdef") != std::string_view::npos) return false;
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  for (std::size_t i = 0; i < kSize; ++i) {
    bytes[i] = static_cast<unsigned char>(16 * digit(text[2 * i]) + digit(text[2 * i + 1]));
  }
  return true;
}

std::string SignedBytes(const Digest& digest) {
  std::string bytes(kSignaturePrefix);
  for (const unsigned char byte : digest) bytes += static_cast<char>(byte);
  return bytes;
}

const unsigned char* Raw(std::string_view bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

std::pair<Digest, Secret> MakePair(const std::array<unsigned char, 32>& seed) {
  InitSodium();
  std::pair<Digest, Secret> keys;
  crypto_sign_seed_keypair(keys.first.data(), keys.second.data(), seed.data());
  return keys;
}

}  // namespace

Digest CalcDigest(std::string_view first, std::string_view rest) {
  InitSodium();
  Digest digest;
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, digest.size());
  crypto_generichash_update(&state, Raw(first), first.size());
  crypto_generichash_update(&state, Raw(rest), rest.size());
  crypto_generichash_final(&state, digest.data(), digest.size());
  return digest;
}

std::string ToHex(const Digest& digest) {
  return Hex(digest);
}

std::string ShortKey(const PublicKey& key) {
  return key.substr(0, 16);
}

SealKey SealKey::Make() {
  InitSodium();
  SealKey key;
  randombytes_buf(key.seed_.data(), key.seed_.size());
  return key;
}

SealKey SealKey::ParseSecret(std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  SealKey key;
  if (!text.starts_with(kSecretPrefix) || !ParseHex(text.substr(kSecretPrefix.size()), key.seed_)) {
    throw Error("is not a kerf secret key");
  }
  return key;
}

std::string SealKey::FormatSecret() const {
  return fmt::format("{}{}\n", kSecretPrefix, Hex(seed_));
}

PublicKey SealKey::public_key() const {
  return Hex(MakePair(seed_).first);
}

std::string SealKey::Sign(const Digest& digest) const {
  const Secret secret = MakePair(seed_).second;
  const std::string bytes = SignedBytes(digest);
  Signature signature;
  crypto_sign_detached(signature.data(), nullptr, Raw(bytes), bytes.size(), secret.data());
  return Hex(signature);
}

bool IsSignedBy(const Digest& digest, const PublicKey& key, std::string_view signature) {
  InitSodium();
  Digest raw_key;
  Signature raw_signature;
  if (!ParseHex(key, raw_key) || !ParseHex(signature, raw_signature)) return false;
  const std::string bytes = SignedBytes(digest);
  return crypto_sign_verify_detached(raw_signature.data(), Raw(bytes), bytes.size(), raw_key.data()) == 0;
}

SealBlock MakeSeal(const Digest& digest, const std::optional<SealKey>& key) {
  SealBlock seal;
  seal.digest = digest;
  if (key) {
    seal.key = key->public_key();
    seal.signature = key->Sign(digest);
  }
  return seal;
}

std::string FormatSeal(const SealBlock& seal) {
  nlohmann::ordered_json json{{"digest", Hex(seal.digest)}};
  if (!seal.key.empty()) {
    json["key"] = seal.key;
    json["signature"] = seal.signature;
  }
  return json.dump();
}

SealBlock ParseSeal(const std::string& text) {
  const nlohmann::ordered_json json = nlohmann::ordered_json::parse(text, nullptr, false);
  SealBlock seal;
  const auto get = [&](const char* key) {
    const auto it = json.is_object() ? json.find(key) : json.end();
    return it != json.end() && it->is_string() ? it->get<std::string>() : "";
  };
  if (!ParseHex(get("digest"), seal.digest)) throw Error("its seal has no digest");
  seal.key = get("key");
  seal.signature = get("signature");
  if (Digest raw; !seal.key.empty() && !ParseHex(seal.key, raw)) throw Error("its seal has an invalid key");
  return seal;
}

std::string DescribeSeal(const RecordingSeal& seal, const std::vector<KnownKey>& known) {
  if (!seal.is_chained) return "not sealed: written as version 1 of the format, which has no chain";
  if (seal.is_broken) return "chain broken: changed after it was written; no signature is valid";
  if (!seal.is_whole)
    return "the chain is intact for the blocks that were read, but does not reach a seal; no signature is valid";
  if (seal.signer.empty()) return "chain intact; not signed";
  std::string owner = "owner unknown";
  for (const KnownKey& one : known) {
    if (one.key == seal.signer) owner = one.owner;
  }
  return fmt::format("chain intact; signed by key {} ({})", ShortKey(seal.signer), owner);
}

std::string FindKeyFile() {
  const std::string config = FindUserFolder(UserFolder::kConfig);
  if (!config.empty()) return config + "/kerf/recording.key";
  throw Error("the location of the key file is unknown: neither XDG_CONFIG_HOME nor HOME is an absolute path");
}

SealKey MakeKeyFile() {
  const std::string path = FindKeyFile();
  const auto fail = [&](int code) { throw Error(fmt::format("{}: can't be written: {}", path, FormatErrno(code))); };
  MakeFolder(std::filesystem::path(path).parent_path().string());
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0 && errno == EEXIST) {
    throw Error(fmt::format("{}: already exists; a key is never replaced", path));
  }
  if (file < 0) fail(errno);
  const SealKey key = SealKey::Make();
  const std::string text = key.FormatSecret();
  errno = ENOSPC;
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && fsync(file) == 0;
  const int code = errno;
  const bool closed = close(file) == 0;
  if (!written || !closed) {
    unlink(path.c_str());
    fail(code);
  }
  return key;
}

std::optional<SealKey> ReadKeyFile() {
  if (FindUserFolder(UserFolder::kConfig).empty()) return std::nullopt;
  const std::string path = FindKeyFile();
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    // EACCES: the home directory belongs to another user, as may happen in a service, and thus contains no key of this
    // user.
    if (errno == ENOENT || errno == ENOTDIR || errno == EACCES) return std::nullopt;
    throw Error(fmt::format("{}: can't be read: {}", path, FormatErrno(errno)));
  }
  if ((status.st_mode & kOthers) != 0) {
    throw Error(fmt::format("{}: is accessible to other users; restrict it with 'chmod 600', or remove it", path));
  }
  try {
    return SealKey::ParseSecret(ReadTextFile(path, kMaxKeyBytes));
  } catch (const Error& e) {
    const std::string what = e.what();
    throw Error(what.starts_with(path) ? what : fmt::format("{}: {}", path, what));
  }
}

std::vector<KnownKey> ListOwnKeys() {
  try {
    const std::optional<SealKey> key = ReadKeyFile();
    if (key) return {{key->public_key(), "this installation's"}};
  } catch (const Error&) {
    // An unusable key is an error only when recording.
  }
  return {};
}

std::string FormatPublicKey(const PublicKey& key) {
  return fmt::format("{}{}", kPublicPrefix, key);
}

std::vector<KnownKey> ReadPublicKeys(const std::string& file) {
  const std::string text = ReadTextFile(file, kMaxKeyBytes);
  std::vector<KnownKey> keys;
  int number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = std::string_view(text).substr(at, end - at);
    at = end + 1;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos || line.starts_with('#')) continue;
    constexpr std::size_t kDigits = 64;
    Digest raw;
    const bool has_prefix = line.starts_with(kPublicPrefix);
    if (has_prefix) line.remove_prefix(kPublicPrefix.size());
    if (!has_prefix || !ParseHex(line.substr(0, kDigits), raw) || (line.size() > kDigits && line[kDigits] != ' ')) {
      throw Error(fmt::format("{}: line {} is not \"{}\" and 64 hexadecimal digits, as 'kerf log --show-key' prints it",
                              file, number, kPublicPrefix.substr(0, kPublicPrefix.size() - 1)));
    }
    const std::string name(line.size() > kDigits ? line.substr(kDigits + 1) : "");
    keys.push_back(
        {std::string(line.substr(0, kDigits)), name.empty() ? "in " + file : fmt::format("{}, in {}", name, file)});
  }
  if (keys.empty()) throw Error(fmt::format("{}: contains no public key", file));
  return keys;
}

}  // namespace kerf
