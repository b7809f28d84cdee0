#include "idl/client_id.h"

#include <cstdint>
#include <random>

namespace handgraft::idl {

v1::ClientId randomClient() {
  std::random_device device;
  v1::ClientId id{};
  for (auto& byte : id)
    byte = static_cast<std::uint8_t>(device());
  return id;
}

}  // namespace handgraft::idl
