#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "idl/security/identity.h"

namespace handgraft::idl::security {

/// A certificate authority in a folder: its key, which no other machine needs, and a folder for
/// each identity that it made.
///
/// Keys have mode 0600, folders 0700. Nothing that is there is written over, but the list of
/// what was revoked. Errors of every call: InvalidInput, which names the file.
class Authority {
 public:
  static constexpr int kOwnDays = 3650;
  static constexpr int kMostDays = 3650;

  /// Makes the folder, or fills an empty one. Errors also: one that holds anything.
  static Authority make(const std::filesystem::path& folder);
  static Authority open(const std::filesystem::path& folder);

  /// A new identity in the folder `NAME` of the authority's, valid from a day ago, since clocks
  /// differ, for so many days. Errors also: a name that is taken, also by a revoked one, or
  /// that is no letter and then letters, digits, `_` and `-`, 32 in all; days outside 1 to
  /// kMostDays; an authority that ends sooner, or has ended.
  Identity add(const std::string& name, Role role, int days);

  /// What it knows of an identity.
  struct Entry {
    std::string name;
    Role role = Role::kViewer;
    Lifetime lifetime;
    std::optional<std::int64_t> revoked_s;
    std::filesystem::path folder;
    std::string trouble;  ///< what is wrong with its folder; empty: nothing
  };

  /// All, by name.
  [[nodiscard]] std::vector<Entry> identities() const;

  /// From now on nobody who reads the new `crl.pem` takes it for what it was; it is put into
  /// all folders below. Errors also: a name that there is not, or that was revoked before.
  void revoke(const std::string& name);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  [[nodiscard]] Lifetime lifetime() const { return certificate_.lifetime(); }

 private:
  Authority(std::filesystem::path folder, Certificate certificate, PrivateKey key);
  [[nodiscard]] RevocationList revocations() const;

  std::filesystem::path folder_;
  Certificate certificate_;
  PrivateKey key_;
};

}  // namespace handgraft::idl::security
