#include "idl/cyclone/entity.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/cyclone/participant.h"

namespace handgraft::idl::cyclone {

std::int32_t checked(std::int32_t result, const char* what, const std::string& where) {
  if (result >= 0) return result;
  const std::string message = fmt::format("{}: {} ({})", where, what, dds_strretcode(result));
  if (result == DDS_RETCODE_TIMEOUT) throw WriteTimeout(message);
  throw TransportError(message);
}

Entity::~Entity() {
  dds_delete(handle_);
}

}  // namespace handgraft::idl::cyclone
