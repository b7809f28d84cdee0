#pragma once

#include <memory>
#include <optional>
#include <string>

#include "idl/security/identity.h"
#include "idl/topics.h"

struct dds_qos;

/// Quality of service as Cyclone takes it.
namespace handgraft::idl::cyclone {

using QosPtr = std::unique_ptr<dds_qos, void (*)(dds_qos*)>;

/// Of a reader or writer that keeps `depth` samples of each instance (idl/README).
QosPtr qosOf(Qos profile, int depth);

/// Of a participant; with an identity Cyclone's own plugins of DDS Security, told who this is.
/// `name`: by which it announces itself; empty: none.
QosPtr participantQos(const std::optional<security::Identity>& identity,
                      const std::string& name);

}  // namespace handgraft::idl::cyclone
