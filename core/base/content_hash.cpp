#include "core/base/content_hash.h"

#include <array>
#include <cstdint>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "core/base/error.h"

namespace handgraft {

void ContentHash::Free::operator()(evp_md_ctx_st* context) const {
  EVP_MD_CTX_free(context);
}

ContentHash::ContentHash() : context_(EVP_MD_CTX_new()) {
  HANDGRAFT_REQUIRE(context_ != nullptr &&
                    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
}

ContentHash::~ContentHash() = default;
ContentHash::ContentHash(ContentHash&&) noexcept = default;
ContentHash& ContentHash::operator=(ContentHash&&) noexcept = default;

void ContentHash::add(std::string_view bytes) {
  HANDGRAFT_REQUIRE(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1);
}

void ContentHash::addText(std::string_view text) {
  addNumber(static_cast<std::uint64_t>(text.size()));
  add(text);
}

std::string ContentHash::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  HANDGRAFT_REQUIRE(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1);
  std::string digits;
  for (unsigned i = 0; i < size; ++i)
    digits += fmt::format("{:02x}", digest[i]);
  return digits;
}

}  // namespace handgraft
