#include "sha256.h"

#include <dn/error.h>
#include <dn/interrupted.h>
#include <fmt/format.h>
#include <openssl/evp.h>

#include <fstream>
#include <memory>
#include <stdexcept>

#include "interruption.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = std::size_t{1} << 20;

/// Computes the SHA-256 of all bytes that are added.
class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    Expect(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }

  void Add(const char* bytes, std::size_t count) {
    Expect(EVP_DigestUpdate(context_.get(), bytes, count) == 1);
  }

  std::string Hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int length = 0;
    Expect(EVP_DigestFinal_ex(context_.get(), digest, &length) == 1);
    std::string text;
    for (unsigned int k = 0; k < length; ++k) text += fmt::format("{:02x}", digest[k]);
    return text;
  }

 private:
  static void Expect(bool done) {
    if (!done) throw std::runtime_error("SHA-256 is not available from libcrypto");
  }

  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string Sha256Hex(std::string_view bytes) {
  Sha256 hash;
  hash.Add(bytes.data(), bytes.size());
  return hash.Hex();
}

std::optional<FileIdentity> IdentifyFile(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  FileIdentity identity;
  Sha256 hash;
  std::string piece(kPiece, '\0');
  while (in) {
    if (SignalReceived()) throw dn::Interrupted();
    in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    hash.Add(piece.data(), count);
    identity.bytes += count;
  }
  if (in.bad()) return std::nullopt;
  identity.sha256 = hash.Hex();
  return identity;
}

const std::string& ProgramHash() {
  static const std::string hash = [] {
    const auto identity = IdentifyFile("/proc/self/exe");
    if (identity) return identity->sha256;
    throw InvalidInput("the program file cannot be read, but records need its hash",
                       {"/proc/self/exe"});
  }();
  return hash;
}

}  // namespace dn::apps
