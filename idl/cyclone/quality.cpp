#include "idl/cyclone/quality.h"

#include <string>

#include <dds/dds.h>
#include <fmt/format.h>

namespace handgraft::idl::cyclone {

namespace {

struct Plugin {
  const char* kind;
  const char* library;
  const char* init;
  const char* finalize;
};

constexpr Plugin kPlugins[] = {
    {"auth", "dds_security_auth", "init_authentication", "finalize_authentication"},
    {"access", "dds_security_ac", "init_access_control", "finalize_access_control"},
    {"crypto", "dds_security_crypto", "init_crypto", "finalize_crypto"}};

}  // namespace

QosPtr participantQos(const std::optional<security::Identity>& identity,
                      const std::string& name) {
  QosPtr qos(dds_create_qos(), dds_delete_qos);
  if (!name.empty()) dds_qset_entity_name(qos.get(), name.c_str());
  if (!identity) return qos;
  const auto put = [&](const std::string& key, const std::string& value) {
    dds_qset_prop(qos.get(), key.c_str(), value.c_str());
  };
  for (const Plugin& plugin : kPlugins) {
    const std::string prefix = fmt::format("dds.sec.{}.library.", plugin.kind);
    put(prefix + "path", plugin.library);
    put(prefix + "init", plugin.init);
    put(prefix + "finalize", plugin.finalize);
  }
  const auto put_file = [&](const char* key, const char* file) {
    put(key, "file:" + identity->file(file));
  };
  put_file("dds.sec.auth.identity_ca", security::kAuthorityFile);
  put_file("dds.sec.auth.identity_certificate", security::kCertificateFile);
  put_file("dds.sec.auth.private_key", security::kKeyFile);
  put_file("org.eclipse.cyclonedds.sec.auth.crl", security::kRevokedFile);
  put_file("dds.sec.access.permissions_ca", security::kAuthorityFile);
  put_file("dds.sec.access.governance", security::kGovernanceFile);
  put_file("dds.sec.access.permissions", security::kPermissionsFile);
  return qos;
}

QosPtr qosOf(Qos profile, int depth) {
  QosPtr qos(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  // A dispose crosses the vendors with the wrong instance: never send one by accident.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability(
      qos.get(), isKept(profile) ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  if (isKept(profile)) {
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED);
  }
  return qos;
}

}  // namespace handgraft::idl::cyclone
