// libcrypto 3.0.
#include "idl/security/certificates.h"

#include <algorithm>
#include <array>
#include <ctime>

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509v3.h>

#include "core/base/error.h"

namespace handgraft::idl::security {

namespace {

template <auto Free>
struct FreeBy {
  template <class T>
  void operator()(T* one) const {
    Free(one);
  }
};

using Bio = std::unique_ptr<BIO, FreeBy<BIO_free_all>>;
using Name = std::unique_ptr<X509_NAME, FreeBy<X509_NAME_free>>;
using Time = std::unique_ptr<ASN1_TIME, FreeBy<ASN1_STRING_free>>;
using Integer = std::unique_ptr<ASN1_INTEGER, FreeBy<ASN1_STRING_free>>;
using BigNumber = std::unique_ptr<BIGNUM, FreeBy<BN_free>>;
using Signed = std::unique_ptr<PKCS7, FreeBy<PKCS7_free>>;

// What libcrypto refuses here is not the user's doing: no memory, no randomness.
void require(bool done, const char* what) {
  if (done) return;
  std::array<char, 256> why{};
  ERR_error_string_n(ERR_get_error(), why.data(), why.size());
  throw std::runtime_error(fmt::format("libcrypto: {} ({})", what, why.data()));
}

Bio memory(const std::string& text = "") {
  Bio bio(text.empty() ? BIO_new(BIO_s_mem())
                       : BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
  require(bio != nullptr, "no memory");
  return bio;
}

std::string textOf(BIO* bio) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio, &bytes);
  return {bytes, static_cast<std::size_t>(size)};
}

Name nameOfSubject(const std::string& common_name) {
  Name name(X509_NAME_new());
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of text
  const auto* bytes = reinterpret_cast<const unsigned char*>(common_name.data());
  require(name != nullptr &&
              X509_NAME_add_entry_by_NID(name.get(), NID_commonName, V_ASN1_UTF8STRING, bytes,
                                         static_cast<int>(common_name.size()), -1, 0) == 1,
          "no name");
  return name;
}

std::int64_t secondsOf(const ASN1_TIME* time) {
  std::tm utc{};
  if (time == nullptr || ASN1_TIME_to_tm(time, &utc) != 1) return 0;
  return timegm(&utc);
}

std::string digitsOf(const ASN1_INTEGER* number) {
  const BigNumber big(ASN1_INTEGER_to_BN(number, nullptr));
  char* text = BN_bn2hex(big.get());
  std::string digits = text == nullptr ? "" : text;
  OPENSSL_free(text);
  return digits;
}

/// Of its subject, which no other certificate of an authority shares: a list of numbers that
/// were revoked then tells whose GUIDs are to be refused (guids.h).
Integer serialOf(const std::string& common_name) {
  const SubjectDigest digest = digestOfSubject(common_name);
  const BigNumber big(BN_bin2bn(digest.data(), static_cast<int>(digest.size()), nullptr));
  require(big != nullptr, "no number");
  return Integer(BN_to_ASN1_INTEGER(big.get(), nullptr));
}

void extend(X509* certificate, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, FreeBy<X509_EXTENSION_free>> extension(
      X509V3_EXT_conf_nid(nullptr, &context, kind, value));
  require(extension != nullptr && X509_add_ext(certificate, extension.get(), -1) == 1,
          "no extension");
}

std::shared_ptr<X509> unsignedCertificate(const std::string& common_name,
                                          EVP_PKEY* key,
                                          const Lifetime& lifetime) {
  std::shared_ptr<X509> made(X509_new(), X509_free);
  require(made != nullptr, "no certificate");
  const Integer serial = serialOf(common_name);
  require(
      X509_set_version(made.get(), X509_VERSION_3) == 1 &&
          X509_set_serialNumber(made.get(), serial.get()) == 1 &&
          X509_set_subject_name(made.get(), nameOfSubject(common_name).get()) == 1 &&
          X509_set_pubkey(made.get(), key) == 1 &&
          ASN1_TIME_set(X509_getm_notBefore(made.get()), lifetime.not_before_s) != nullptr &&
          ASN1_TIME_set(X509_getm_notAfter(made.get()), lifetime.not_after_s) != nullptr,
      "no certificate");
  return made;
}

}  // namespace

// === Keys

PrivateKey PrivateKey::make() {
  PrivateKey made;
  made.key_.reset(EVP_EC_gen("P-256"), EVP_PKEY_free);
  require(made.key_ != nullptr, "no key");
  return made;
}

PrivateKey PrivateKey::read(const std::string& pem, const std::string& where) {
  PrivateKey made;
  // An empty pass phrase, or libcrypto would ask for one at the terminal.
  std::array<char, 1> none{};
  made.key_.reset(PEM_read_bio_PrivateKey(memory(pem).get(), nullptr, nullptr, none.data()),
                  EVP_PKEY_free);
  if (made.key_ == nullptr) rejectInput("{}: no private key in PEM without a password", where);
  return made;
}

std::string PrivateKey::pem() const {
  const Bio bio = memory();
  require(PEM_write_bio_PKCS8PrivateKey(bio.get(), key_.get(), nullptr, nullptr, 0, nullptr,
                                        nullptr) == 1,
          "no key");
  return textOf(bio.get());
}

// === Certificates

Certificate Certificate::makeAuthority(const std::string& common_name,
                                       const PrivateKey& key,
                                       const Lifetime& lifetime) {
  Certificate made;
  made.certificate_ = unsignedCertificate(common_name, key.key_.get(), lifetime);
  X509* self = made.certificate_.get();
  require(X509_set_issuer_name(self, X509_get_subject_name(self)) == 1, "no issuer");
  extend(self, self, NID_basic_constraints, "critical,CA:TRUE");
  extend(self, self, NID_subject_key_identifier, "hash");
  require(X509_sign(self, key.key_.get(), EVP_sha256()) != 0, "no signature");
  return made;
}

Certificate Certificate::issue(const std::string& common_name,
                               const PrivateKey& key,
                               const Lifetime& lifetime,
                               const Certificate& authority,
                               const PrivateKey& authority_key) {
  Certificate made;
  made.certificate_ = unsignedCertificate(common_name, key.key_.get(), lifetime);
  X509* self = made.certificate_.get();
  X509* issuer = authority.certificate_.get();
  require(X509_set_issuer_name(self, X509_get_subject_name(issuer)) == 1, "no issuer");
  extend(self, issuer, NID_basic_constraints, "critical,CA:FALSE");
  extend(self, issuer, NID_authority_key_identifier, "keyid");
  require(X509_sign(self, authority_key.key_.get(), EVP_sha256()) != 0, "no signature");
  return made;
}

Certificate Certificate::read(const std::string& pem, const std::string& where) {
  Certificate made;
  made.certificate_.reset(PEM_read_bio_X509(memory(pem).get(), nullptr, nullptr, nullptr),
                          X509_free);
  if (made.certificate_ == nullptr) rejectInput("{}: no certificate in PEM", where);
  return made;
}

std::string Certificate::pem() const {
  const Bio bio = memory();
  require(PEM_write_bio_X509(bio.get(), certificate_.get()) == 1, "no certificate");
  return textOf(bio.get());
}

std::string Certificate::commonName() const {
  const X509_NAME* subject = X509_get_subject_name(certificate_.get());
  const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (at < 0 || X509_NAME_entry_count(subject) != 1) return "";
  const ASN1_STRING* text = X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at));
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of text
  return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
          static_cast<std::size_t>(ASN1_STRING_length(text))};
}

Lifetime Certificate::lifetime() const {
  return {secondsOf(X509_get0_notBefore(certificate_.get())),
          secondsOf(X509_get0_notAfter(certificate_.get()))};
}

std::string Certificate::serial() const {
  return digitsOf(X509_get0_serialNumber(certificate_.get()));
}

bool Certificate::isSignedBy(const Certificate& authority) const {
  X509* issuer = authority.certificate_.get();
  const bool is_so = X509_NAME_cmp(X509_get_issuer_name(certificate_.get()),
                                   X509_get_subject_name(issuer)) == 0 &&
                     X509_verify(certificate_.get(), X509_get0_pubkey(issuer)) == 1;
  ERR_clear_error();
  return is_so;
}

bool Certificate::belongsTo(const PrivateKey& key) const {
  const bool is_so = X509_check_private_key(certificate_.get(), key.key_.get()) == 1;
  ERR_clear_error();
  return is_so;
}

// === What is taken back

RevocationList RevocationList::make(const std::vector<Entry>& entries,
                                    const Certificate& authority,
                                    const PrivateKey& authority_key,
                                    const Lifetime& lifetime) {
  RevocationList made;
  made.list_.reset(X509_CRL_new(), X509_CRL_free);
  X509_CRL* list = made.list_.get();
  const Time begin(ASN1_TIME_set(nullptr, lifetime.not_before_s));
  const Time end(ASN1_TIME_set(nullptr, lifetime.not_after_s));
  constexpr long kSecondVersion = 1;
  require(list != nullptr && X509_CRL_set_version(list, kSecondVersion) == 1 &&
              X509_CRL_set_issuer_name(
                  list, X509_get_subject_name(authority.certificate_.get())) == 1 &&
              X509_CRL_set1_lastUpdate(list, begin.get()) == 1 &&
              X509_CRL_set1_nextUpdate(list, end.get()) == 1,
          "no revocation list");
  for (const Entry& entry : entries) {
    std::unique_ptr<X509_REVOKED, FreeBy<X509_REVOKED_free>> one(X509_REVOKED_new());
    BIGNUM* number = nullptr;
    require(one != nullptr && BN_hex2bn(&number, entry.serial.c_str()) > 0, "no number");
    const BigNumber big(number);
    const Integer serial(BN_to_ASN1_INTEGER(big.get(), nullptr));
    const Time when(ASN1_TIME_set(nullptr, entry.when_s));
    require(X509_REVOKED_set_serialNumber(one.get(), serial.get()) == 1 &&
                X509_REVOKED_set_revocationDate(one.get(), when.get()) == 1 &&
                X509_CRL_add0_revoked(list, one.get()) == 1,
            "no entry");
    static_cast<void>(one.release());  // the list's now
  }
  X509_CRL_sort(list);
  require(X509_CRL_sign(list, authority_key.key_.get(), EVP_sha256()) != 0, "no signature");
  return made;
}

RevocationList RevocationList::read(const std::string& pem, const std::string& where) {
  RevocationList made;
  made.list_.reset(PEM_read_bio_X509_CRL(memory(pem).get(), nullptr, nullptr, nullptr),
                   X509_CRL_free);
  if (made.list_ == nullptr) rejectInput("{}: no revocation list in PEM", where);
  return made;
}

std::string RevocationList::pem() const {
  const Bio bio = memory();
  require(PEM_write_bio_X509_CRL(bio.get(), list_.get()) == 1, "no revocation list");
  return textOf(bio.get());
}

std::vector<RevocationList::Entry> RevocationList::entries() const {
  std::vector<Entry> entries;
  STACK_OF(X509_REVOKED)* all = X509_CRL_get_REVOKED(list_.get());
  for (int i = 0; i < sk_X509_REVOKED_num(all); ++i) {
    const X509_REVOKED* one = sk_X509_REVOKED_value(all, i);
    entries.push_back({digitsOf(X509_REVOKED_get0_serialNumber(one)),
                       secondsOf(X509_REVOKED_get0_revocationDate(one))});
  }
  return entries;
}

bool RevocationList::isSignedBy(const Certificate& authority) const {
  const bool is_so =
      X509_CRL_verify(list_.get(), X509_get0_pubkey(authority.certificate_.get())) == 1;
  ERR_clear_error();
  return is_so;
}

// === Documents

std::string signDocument(const std::string& text,
                         const Certificate& authority,
                         const PrivateKey& authority_key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const Bio in = memory(text);
  const Signed made(PKCS7_sign(authority.certificate_.get(), authority_key.key_.get(), nullptr,
                               in.get(), kFlags | PKCS7_STREAM));
  const Bio out = memory();
  require(made != nullptr &&
              SMIME_write_PKCS7(out.get(), made.get(), in.get(), kFlags | PKCS7_STREAM) == 1,
          "no signature");
  return textOf(out.get());
}

std::optional<std::string> openDocument(const std::string& document,
                                        const Certificate& authority) {
  BIO* content = nullptr;
  const Signed read(SMIME_read_PKCS7(memory(document).get(), &content));
  const Bio clear(content);
  const std::unique_ptr<X509_STORE, FreeBy<X509_STORE_free>> store(X509_STORE_new());
  const Bio out = memory();
  require(X509_STORE_add_cert(store.get(), authority.certificate_.get()) == 1, "no store");
  // When the authority ends is told apart from what it signed.
  X509_STORE_set_flags(store.get(), X509_V_FLAG_NO_CHECK_TIME);
  const bool is_signed =
      read != nullptr && content != nullptr &&
      PKCS7_verify(read.get(), nullptr, store.get(), clear.get(), out.get(), PKCS7_TEXT) == 1;
  ERR_clear_error();
  if (!is_signed) return std::nullopt;
  return textOf(out.get());
}

SubjectDigest digestOfSubject(const std::string& common_name) {
  unsigned char* bytes = nullptr;
  const int size = i2d_X509_NAME(nameOfSubject(common_name).get(), &bytes);
  require(size > 0, "no name");
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  const int done = EVP_Digest(bytes, static_cast<std::size_t>(size), digest.data(), nullptr,
                              EVP_sha256(), nullptr);
  OPENSSL_free(bytes);
  require(done == 1, "no digest");
  SubjectDigest first{};
  std::copy_n(digest.begin(), first.size(), first.begin());
  return first;
}

}  // namespace handgraft::idl::security
