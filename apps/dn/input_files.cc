#include "input_files.h"

#include <dn/interrupted.h>
#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>

#include "interruption.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = std::size_t{1} << 20;

/// Computes the SHA-256 (FIPS 180-4) of the added bytes.
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

struct Identity {
  std::uintmax_t bytes = 0;
  std::string sha256;
};

std::optional<Identity> IdentityOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  Identity identity;
  Sha256 hash;
  std::string piece(kPiece, '\0');
  while (in) {
    if (SignalCame()) throw dn::Interrupted();
    in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    hash.Add(piece.data(), count);
    identity.bytes += count;
  }
  if (in.bad()) return std::nullopt;
  identity.sha256 = hash.Hex();
  return identity;
}

std::string NameInFlight(const fs::path& file, const std::vector<fs::path>& folders) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  for (const fs::path& folder : folders) {
    const fs::path inside =
        whole.lexically_relative((fs::absolute(folder) / "").lexically_normal());
    if (!inside.empty() && *inside.begin() != ".." && inside != ".") return inside.string();
  }
  return file.string();
}

}  // namespace

Json InputFilesJson(const Inputs& inputs) {
  Json list = Json::array();
  std::set<fs::path> seen;
  for (const fs::path& file : inputs.files) {
    std::error_code none;
    const fs::path canonical = fs::canonical(file, none);
    if (none || !fs::is_regular_file(canonical, none) || !seen.insert(canonical).second) continue;
    const auto identity = IdentityOf(file);
    if (!identity) continue;
    list.push_back({{"file", NameInFlight(file, inputs.folders)},
                    {"bytes", identity->bytes},
                    {"sha256", identity->sha256}});
  }
  return list;
}

}  // namespace dn::apps
