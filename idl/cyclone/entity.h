#pragma once

#include <cstdint>
#include <string>

namespace handgraft::idl::cyclone {

/// What Cyclone returned: handles and counts are >= 0, errors below.
/// Errors: WriteTimeout, TransportError: "`where`: `what` (Cyclone's words)".
std::int32_t checked(std::int32_t result, const char* what, const std::string& where);

/// An entity of Cyclone's that is deleted with its owner.
class Entity {
 public:
  Entity(std::int32_t handle, const char* what, const std::string& where)
      : handle_(checked(handle, what, where)) {}

  ~Entity();
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;

  [[nodiscard]] std::int32_t get() const { return handle_; }

 private:
  std::int32_t handle_;
};

}  // namespace handgraft::idl::cyclone
