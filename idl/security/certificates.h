#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

struct evp_pkey_st;
struct x509_st;
struct X509_crl_st;

namespace handgraft::idl::security {

/// An EC key on prime256v1 (FIPS 186-4 P-256): what both vendors take, and start in 0.2 s by.
class PrivateKey {
 public:
  static PrivateKey make();
  /// Errors: InvalidInput, beginning with `where`.
  static PrivateKey read(const std::string& pem, const std::string& where);
  [[nodiscard]] std::string pem() const;

 private:
  friend class Certificate;
  friend class RevocationList;
  friend std::string signDocument(const std::string&,
                                  const class Certificate&,
                                  const PrivateKey&);

  std::shared_ptr<evp_pkey_st> key_;
};

/// Seconds since 1970, both included.
struct Lifetime {
  std::int64_t not_before_s = 0;
  std::int64_t not_after_s = 0;
};

/// An X.509 certificate whose subject is one common name: more of a subject is written in
/// another order by each vendor.
class Certificate {
 public:
  static Certificate makeAuthority(const std::string& common_name,
                                   const PrivateKey& key,
                                   const Lifetime& lifetime);
  /// Of `key`'s public half, signed by the authority.
  static Certificate issue(const std::string& common_name,
                           const PrivateKey& key,
                           const Lifetime& lifetime,
                           const Certificate& authority,
                           const PrivateKey& authority_key);
  /// Errors: InvalidInput, beginning with `where`.
  static Certificate read(const std::string& pem, const std::string& where);
  [[nodiscard]] std::string pem() const;

  [[nodiscard]] std::string commonName() const;
  [[nodiscard]] Lifetime lifetime() const;
  /// Hexadecimal, capitals: the digest of its subject.
  [[nodiscard]] std::string serial() const;
  [[nodiscard]] bool isSignedBy(const Certificate& authority) const;
  [[nodiscard]] bool belongsTo(const PrivateKey& key) const;

 private:
  friend class RevocationList;
  friend std::string signDocument(const std::string&, const Certificate&, const PrivateKey&);
  friend std::optional<std::string> openDocument(const std::string&, const Certificate&);

  std::shared_ptr<x509_st> certificate_;
};

/// The certificates that an authority takes back.
class RevocationList {
 public:
  struct Entry {
    std::string serial;  ///< as Certificate::serial
    std::int64_t when_s = 0;
  };

  static RevocationList make(const std::vector<Entry>& entries,
                             const Certificate& authority,
                             const PrivateKey& authority_key,
                             const Lifetime& lifetime);
  /// Errors: InvalidInput, beginning with `where`.
  static RevocationList read(const std::string& pem, const std::string& where);
  [[nodiscard]] std::string pem() const;
  [[nodiscard]] std::vector<Entry> entries() const;
  [[nodiscard]] bool isSignedBy(const Certificate& authority) const;

 private:
  std::shared_ptr<X509_crl_st> list_;
};

/// As S/MIME 3.2 with the text in clear, which is what DDS Security 1.1 asks for (9.4.1).
std::string signDocument(const std::string& text,
                         const Certificate& authority,
                         const PrivateKey& authority_key);

/// Its text; nothing unless the authority signed it.
std::optional<std::string> openDocument(const std::string& document,
                                        const Certificate& authority);

/// The first bytes of SHA-256 of a subject of that common name, in DER.
using SubjectDigest = std::array<std::uint8_t, 16>;
SubjectDigest digestOfSubject(const std::string& common_name);

}  // namespace handgraft::idl::security
