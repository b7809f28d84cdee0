#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"
#include "idl/fields.h"
#include "idl/security/authority.h"
#include "idl/security/documents.h"
#include "idl/security/guids.h"
#include "idl/security/revocations.h"

namespace handgraft::idl::security {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kDay = 24 * 3600;

class Keys : public testing::Test {
 protected:
  Keys() {
    std::string pattern = (fs::temp_directory_path() / "handgraft_keys_XXXXXX").string();
    folder = mkdtemp(pattern.data());
  }

  ~Keys() override { fs::remove_all(folder); }

  Authority authority(const std::string& name = "ca") const {
    return Authority::make(folder / name);
  }

  static unsigned modeOf(const fs::path& path) {
    struct stat about {};

    EXPECT_EQ(stat(path.c_str(), &about), 0) << path;
    return about.st_mode & 0777U;
  }

  /// What is said of an identity's folder.
  static std::string refusal(const fs::path& folder,
                             std::initializer_list<Role> roles = {Role::kServer,
                                                                  Role::kOperator,
                                                                  Role::kEditor, Role::kViewer,
                                                                  Role::kHand},
                             std::int64_t now_s = nowInSeconds()) {
    try {
      readIdentity(folder, roles, now_s);
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  }

  template <class Call>
  static std::string refusalOf(const Call& call) {
    try {
      call();
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  }

  static bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }

  fs::path folder;
};

TEST_F(Keys, MakesIdentitiesOfEveryRoleForTheirOwnersAlone) {
  Authority ca = authority();
  EXPECT_EQ(modeOf(ca.folder()), 0700U);
  EXPECT_EQ(modeOf(ca.folder() / "ca.key"), 0600U);
  for (const Role role : kRoles) {
    const std::string name = std::string("a-") + nameOf(role);
    const Identity made = ca.add(name, role, 30);
    EXPECT_EQ(modeOf(made.folder), 0700U);
    EXPECT_EQ(modeOf(made.folder / kKeyFile), 0600U);
    EXPECT_FALSE(fs::exists(made.folder / "ca.key"));
    const Identity read = readIdentity(made.folder, {role});
    EXPECT_EQ(read.name, name);
    EXPECT_EQ(read.role, role);
    EXPECT_NEAR(static_cast<double>(read.lifetime.not_after_s),
                static_cast<double>(nowInSeconds() + 30 * kDay), 60.0);
    EXPECT_LE(read.lifetime.not_before_s, nowInSeconds() - kDay);
  }
}

TEST_F(Keys, HasCyclonesHandshakeBegin) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(isHigh(guidBeginOf(makeCommonName("s", Role::kServer))));
    EXPECT_FALSE(isHigh(guidBeginOf(makeCommonName("h", Role::kHand))));
  }
}

TEST_F(Keys, WritesNothingOver) {
  Authority ca = authority();
  ca.add("anna", Role::kEditor, 30);
  EXPECT_TRUE(has(refusalOf([&] {
                    authority();
                  }),
                  "is an authority already"));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.add("anna", Role::kViewer, 30);
                  }),
                  "'anna' is taken"));
  EXPECT_EQ(readIdentity(ca.folder() / "anna", {Role::kEditor}).role, Role::kEditor);
  fs::create_directory(folder / "full");
  std::ofstream(folder / "full" / "thesis.tex") << "text";
  EXPECT_TRUE(has(refusalOf([&] {
                    authority("full");
                  }),
                  "holds something"));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.add("../bob", Role::kEditor, 30);
                  }),
                  "a letter"));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.add("bob", Role::kEditor, 0);
                  }),
                  "1-3650"));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.add("bob", Role::kEditor, 3650 + 1);
                  }),
                  "1-3650"));
  EXPECT_TRUE(has(refusalOf([] {
                    roleNamed("boss");
                  }),
                  "server, operator, editor, viewer"));
}

TEST_F(Keys, NamesWhatIsWrongWithAnIdentity) {
  Authority ca = authority();
  const fs::path anna = ca.add("anna", Role::kEditor, 30).folder;
  const fs::path bob = ca.add("bob", Role::kViewer, 30).folder;
  Authority other = authority("other");
  const fs::path stranger = other.add("anna", Role::kEditor, 30).folder;
  EXPECT_EQ(refusal(anna), "");
  EXPECT_TRUE(has(refusal(folder / "nowhere"), "nowhere"));
  EXPECT_TRUE(has(refusal(anna, {Role::kServer}), "is of role editor"));
  EXPECT_TRUE(has(refusal(anna, {Role::kEditor}, nowInSeconds() + 31 * kDay), "expired on"));
  EXPECT_TRUE(
      has(refusal(anna, {Role::kEditor}, nowInSeconds() - 3 * kDay), "not valid before"));

  chmod((anna / kKeyFile).c_str(), 0640);
  EXPECT_TRUE(has(refusal(anna), "key.pem: others than its owner"));
  chmod((anna / kKeyFile).c_str(), 0600);

  const auto with = [&](const fs::path& from, const char* file) {
    const fs::path mixed = folder / "mixed";
    fs::remove_all(mixed);
    fs::copy(anna, mixed);
    fs::copy_file(from / file, mixed / file, fs::copy_options::overwrite_existing);
    return refusal(mixed);
  };
  EXPECT_TRUE(has(with(stranger, kCertificateFile), "cert.pem: was not signed by"));
  EXPECT_TRUE(has(with(bob, kCertificateFile), "is of another key"));
  EXPECT_TRUE(has(with(bob, kKeyFile), "is of another key"));
  EXPECT_TRUE(has(with(bob, kPermissionsFile), "permissions.p7s: is of another identity"));
  EXPECT_TRUE(has(with(stranger, kPermissionsFile), "permissions.p7s: was not signed by"));
  EXPECT_TRUE(has(with(stranger, kGovernanceFile), "governance.p7s: was not signed by"));
  EXPECT_TRUE(has(with(stranger, kRevokedFile), "crl.pem: was not signed by"));
  for (const char* file : {kAuthorityFile, kCertificateFile, kKeyFile, kGovernanceFile,
                           kPermissionsFile, kRevokedFile}) {
    const fs::path less = folder / "less";
    fs::remove_all(less);
    fs::copy(anna, less);
    fs::remove(less / file);
    EXPECT_TRUE(has(refusal(less), file)) << refusal(less);
    std::ofstream(less / file) << "nonsense";
    chmod((less / file).c_str(), 0600);
    EXPECT_TRUE(has(refusal(less), file)) << refusal(less);
  }
}

TEST_F(Keys, SignedDocumentsCannotBeChanged) {
  Authority ca = authority();
  const fs::path anna = ca.add("anna", Role::kViewer, 30).folder;
  std::string text = readTextFile(anna / kPermissionsFile);
  const std::size_t at = text.find("handgraft/v1/session_state");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 26, "handgraft/v1/hand_command ");
  std::ofstream(anna / kPermissionsFile) << text;
  EXPECT_TRUE(has(refusal(anna), "permissions.p7s: was not signed by"));
}

TEST_F(Keys, TakesIdentitiesBack) {
  Authority ca = authority();
  const fs::path anna = ca.add("anna", Role::kEditor, 30).folder;
  const fs::path bob = ca.add("bob", Role::kEditor, 30).folder;
  ca.revoke("anna");
  EXPECT_TRUE(has(refusal(anna), "was revoked on"));
  EXPECT_EQ(refusal(bob), "");
  EXPECT_EQ(readTextFile(bob / kRevokedFile), readTextFile(ca.folder() / kRevokedFile));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.revoke("anna");
                  }),
                  "was revoked on"));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.revoke("carl");
                  }),
                  "there are anna, bob"));
  EXPECT_TRUE(has(refusalOf([&] {
                    ca.add("anna", Role::kEditor, 30);
                  }),
                  "is taken"));
  // Who comes later knows of it, too; and the next one adds to the list.
  ca.revoke("bob");
  const fs::path carl = ca.add("carl", Role::kEditor, 30).folder;
  EXPECT_EQ(RevocationList::read(readTextFile(carl / kRevokedFile), "carl").entries().size(),
            2U);
  const auto known = Authority::open(ca.folder()).identities();
  ASSERT_EQ(known.size(), 3U);
  EXPECT_TRUE(known[0].revoked_s && known[1].revoked_s && !known[2].revoked_s);
}

TEST_F(Keys, TellsWhoWasRevokedWhileAProgramRuns) {
  Authority ca = authority();
  const Identity lab = ca.add("lab", Role::kServer, 30);
  const fs::path anna = ca.add("anna", Role::kEditor, 30).folder;
  const std::string subject =
      Certificate::read(readTextFile(anna / kCertificateFile), "anna").commonName();
  Revocations revocations(lab);
  ASSERT_TRUE(revocations.look());
  EXPECT_FALSE(revocations.look()) << "nothing changed";
  ca.revoke("anna");
  const auto news = revocations.look();
  ASSERT_TRUE(news);
  EXPECT_EQ(news->trouble, "");
  EXPECT_EQ(news->revoked, std::set<GuidBegin>{guidBeginOf(subject)});
  EXPECT_FALSE(news->is_own);
  // What is no list of the authority's changes nothing.
  const std::string list = readTextFile(lab.file(kRevokedFile));
  fs::copy_file(authority("other").folder() / kRevokedFile, lab.file(kRevokedFile),
                fs::copy_options::overwrite_existing);
  EXPECT_TRUE(has(revocations.look().value().trouble, "was not signed by"));
  fs::remove(lab.file(kRevokedFile));
  EXPECT_TRUE(has(revocations.look().value().trouble, "crl.pem: cannot be read"));
  std::ofstream(lab.file(kRevokedFile)) << list;
  EXPECT_EQ(revocations.look().value().revoked.size(), 1U);
  ca.revoke("lab");
  EXPECT_TRUE(revocations.look().value().is_own);
}

TEST(Guids, NumbersOfOtherAuthoritiesAreNobodys) {
  EXPECT_FALSE(guidBeginOfSerial(""));
  EXPECT_FALSE(guidBeginOfSerial("-1F"));
  EXPECT_FALSE(guidBeginOfSerial(std::string(40, 'A')));
  EXPECT_EQ(guidBeginOfSerial("1").value()[0], 0x80);  // of leading zeros
}

TEST(Rights, EveryOperationIsSomebodysAndUnknownOnesAreNobodys) {
  for (const std::string& name : namesOf(typeOf<v1::Operation>())) {
    const auto operation = v1::enumeratorOf<v1::Operation>(name).value();
    EXPECT_TRUE(name == "unload_model" ||
                idl::traitsOf(operation).privilege != Privilege::kOperate)
        << name;
  }
  EXPECT_EQ(idl::traitsOf(static_cast<v1::Operation>(12345)).privilege, Privilege::kOperate);
}

TEST(Rights, OneRoleAloneSaysWhatOthersTrust) {
  const auto writers = [](const std::string& topic) {
    std::set<Role> roles;
    for (const Role role : kRoles) {
      for (const std::string& one : rightsOf(role, "anna").may_write) {
        if (one == topic) roles.insert(role);
      }
    }
    return roles;
  };
  const std::set<Role> server{Role::kServer};
  const std::set<Role> operators{Role::kOperator};
  const std::set<Role> editors{Role::kOperator, Role::kEditor};
  for (const char* topic : {kReplyTopic.name, kEditReplyTopic.name, kSessionTopic.name,
                            kSolutionTopic.name, kStatusTopic.name})
    EXPECT_EQ(writers(topic), server) << topic;
  EXPECT_EQ(writers(kHandCommandTopic.name), operators);
  EXPECT_EQ(writers(kOperateTopic.name), operators);
  EXPECT_EQ(writers("rt/handgraft/*/joint_trajectory"), operators);
  EXPECT_EQ(writers(kRequestTopic.name), editors);
  EXPECT_EQ(writers(kEditTopic.name), editors);
  EXPECT_EQ(writers(kBridgeStatusTopic.name), std::set<Role>{Role::kHand});
  EXPECT_EQ(rightsOf(Role::kViewer, "anna").may_write,
            std::vector<std::string>{kLookTopic.name});
  for (const Role role : kRoles) {  // a pattern would let in what is not meant
    for (const std::string& one : rightsOf(role, "anna").may_write)
      EXPECT_TRUE(one.rfind("rt/*", 0) != 0 && one != "*" && one != "handgraft/*");
  }
}

}  // namespace
}  // namespace handgraft::idl::security
