#include "idl/security/documents.h"

#include <ctime>

#include <fmt/format.h>

#include "core/base/network.h"

namespace handgraft::idl::security {

namespace {

constexpr std::int64_t kDay = 24L * 3600;  // s

std::string domainsText() {
  return fmt::format("<domains><id_range><min>0</min><max>{}</max></id_range></domains>",
                     kHighestDomain);
}

// Servers are told apart by partitions, which are not what this is about.
std::string partText(const char* tag, const std::vector<std::string>& topics) {
  if (topics.empty()) return "";
  std::string text = fmt::format("    <{}>\n     <topics>\n", tag);
  for (const std::string& topic : topics)
    text += fmt::format("      <topic>{}</topic>\n", topic);
  text += "     </topics>\n     <partitions><partition>*</partition></partitions>\n";
  return text + fmt::format("    </{}>\n", tag);
}

}  // namespace

std::string dateText(std::int64_t time_s) {
  const std::time_t time = time_s;
  std::tm utc{};
  gmtime_r(&time, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", utc.tm_year + 1900, utc.tm_mon + 1,
                     utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec);
}

std::string governanceText() {
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
 <domain_access_rules>
  <domain_rule>
   {}
   <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
   <enable_join_access_control>true</enable_join_access_control>
   <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
   <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
   <rtps_protection_kind>NONE</rtps_protection_kind>
   <topic_access_rules>
    <topic_rule>
     <topic_expression>*</topic_expression>
     <enable_discovery_protection>true</enable_discovery_protection>
     <enable_liveliness_protection>true</enable_liveliness_protection>
     <enable_read_access_control>true</enable_read_access_control>
     <enable_write_access_control>true</enable_write_access_control>
     <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
     <data_protection_kind>NONE</data_protection_kind>
    </topic_rule>
   </topic_access_rules>
  </domain_rule>
 </domain_access_rules>
</dds>
)",
      domainsText());
}

std::string permissionsText(const std::string& name,
                            const std::string& subject,
                            Role role,
                            std::int64_t not_before_s,
                            std::int64_t not_after_s) {
  const Rights rights = rightsOf(role, name);
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
 <permissions>
  <grant name="{}">
   <subject_name>{}</subject_name>
   <validity><not_before>{}</not_before><not_after>{}</not_after></validity>
   <allow_rule>
    {}
{}{}   </allow_rule>
   <default>DENY</default>
  </grant>
 </permissions>
</dds>
)",
      name, subject, dateText(not_before_s - kDay), dateText(not_after_s + kDay), domainsText(),
      partText("publish", rights.may_write), partText("subscribe", rights.may_read));
}

}  // namespace handgraft::idl::security
