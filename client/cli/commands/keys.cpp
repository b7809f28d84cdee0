
#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"
#include "core/base/environment.h"
#include "core/base/error.h"
#include "idl/security/authority.h"
#include "idl/security/documents.h"

namespace handgraft::client {

namespace {

namespace fs = std::filesystem;
namespace security = idl::security;

fs::path usualKeys() {
  if (const auto config = userFolder("XDG_CONFIG_HOME", ".config"))
    return *config / "handgraft" / "keys";
  rejectInput("keys: neither HOME nor XDG_CONFIG_HOME is set; name the folder by --dir");
}

fs::path folderOf(const KeysOptions& options) {
  return options.folder.empty() ? usualKeys() : options.folder;
}

std::string stateOf(const security::Authority::Entry& entry, std::int64_t now_s) {
  if (entry.revoked_s) return "revoked";
  if (!entry.trouble.empty() && now_s > entry.lifetime.not_after_s) return "expired";
  return entry.trouble.empty() ? "valid" : "unfit";
}

json::Json identityJson(const security::Authority::Entry& entry, std::int64_t now_s) {
  json::Json one = {{"name", entry.name},
                    {"role", security::nameOf(entry.role)},
                    {"state", stateOf(entry, now_s)},
                    {"not_before", security::dateText(entry.lifetime.not_before_s) + "Z"},
                    {"not_after", security::dateText(entry.lifetime.not_after_s) + "Z"},
                    {"folder", entry.folder.string()}};
  if (entry.revoked_s) one["revoked"] = security::dateText(*entry.revoked_s) + "Z";
  if (!entry.trouble.empty()) one["trouble"] = entry.trouble;
  return one;
}

int show(const security::Authority& authority, bool as_json) {
  const std::int64_t now_s = security::nowInSeconds();
  const auto identities = authority.identities();
  const std::string end = security::dateText(authority.lifetime().not_after_s);
  if (as_json) {
    json::Json list = json::Json::array();
    for (const auto& entry : identities)
      list.push_back(identityJson(entry, now_s));
    fmt::print("{}\n", json::written({{"folder", authority.folder().string()},
                                      {"not_after", end + "Z"},
                                      {"identities", list}}));
    return 0;
  }
  fmt::print("authority {}, until {} UTC\n\n", authority.folder().string(), end);
  std::vector<std::vector<std::string>> rows = {{"name", "role", "state", "until (UTC)"}};
  std::string troubles;
  for (const auto& entry : identities) {
    rows.push_back({entry.name, security::nameOf(entry.role), stateOf(entry, now_s),
                    security::dateText(entry.lifetime.not_after_s)});
    if (!entry.trouble.empty()) troubles += entry.trouble + "\n";
  }
  fmt::print("{}", rows.size() == 1 ? "no identities; handgraft keys add NAME --role ROLE\n"
                                    : text::table(rows, "l"));
  fmt::print("{}{}", troubles.empty() ? "" : "\n", troubles);
  return 0;
}

void tellOfKeys(bool as_json, const json::Json& document, const std::string& line) {
  fmt::print("{}\n", as_json ? json::written(document) : line);
}

}  // namespace

int run(const KeysOptions& options,
        const CommonOptions& common,
        Interruption& /*interruption*/) {
  const fs::path folder = folderOf(options);
  switch (options.action) {
    case KeysOptions::Action::kInit: {
      std::error_code error;
      if (options.folder.empty()) fs::create_directories(folder.parent_path(), error);
      const auto authority = security::Authority::make(folder);
      const std::string end = security::dateText(authority.lifetime().not_after_s);
      tellOfKeys(
          common.json, {{"folder", authority.folder().string()}, {"not_after", end + "Z"}},
          fmt::format("{}: an authority, until {} UTC. Its ca.key makes identities and is "
                      "needed by no program: keep it apart. Next: handgraft keys add NAME "
                      "--role ROLE{}",
                      authority.folder().string(), end,
                      options.folder.empty() ? "" : " --dir " + options.folder.string()));
      return 0;
    }
    case KeysOptions::Action::kAdd: {
      const security::Role role = security::roleNamed(options.role);
      const auto identity =
          security::Authority::open(folder).add(options.name, role, options.days);
      const std::string end = security::dateText(identity.lifetime.not_after_s);
      tellOfKeys(
          common.json,
          {{"name", identity.name},
           {"role", security::nameOf(role)},
           {"folder", identity.folder.string()},
           {"not_after", end + "Z"}},
          fmt::format("{}: identity {} of role {}, until {} UTC; use it by --identity {}",
                      identity.folder.string(), identity.name, security::nameOf(role), end,
                      identity.folder.string()));
      return 0;
    }
    case KeysOptions::Action::kShow:
      return show(security::Authority::open(folder), common.json);
    case KeysOptions::Action::kRevoke: {
      auto authority = security::Authority::open(folder);
      authority.revoke(options.name);
      const std::string list = (authority.folder() / security::kRevokedFile).string();
      tellOfKeys(
          common.json, {{"name", options.name}, {"revoked", true}, {"list", list}},
          fmt::format("revoked {}. Programs read the list when they start: put {} into the "
                      "folders of identities on other machines, and restart the server",
                      options.name, list));
      return 0;
    }
  }
  return 0;
}

}  // namespace handgraft::client
