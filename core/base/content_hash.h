#pragma once

#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace handgraft {

/// SHA-256 (FIPS 180-4, by libcrypto) of what it is fed: the one hash by which models, uploads,
/// caches and sessions are told apart, so that nobody can make two inputs share one.
///
/// Cost: some 1 ns a byte.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(ContentHash&&) noexcept;
  ContentHash& operator=(ContentHash&&) noexcept;

  void add(std::string_view bytes);

  /// The text and its length: what follows it cannot be taken for a part of it.
  void addText(std::string_view text);

  /// The bytes of `count` plain numbers.
  template <class Number>
  void addNumbers(const Number* numbers, std::size_t count) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of plain numbers
    add({reinterpret_cast<const char*>(numbers), count * sizeof(Number)});
  }

  template <class Number>
  void addNumber(Number number) {
    addNumbers(&number, 1);
  }

  /// 64 hexadecimal digits. The hash is spent afterwards.
  std::string finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };

  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

}  // namespace handgraft
