#include "core/base/random_id.h"

#include <random>

namespace handgraft {

std::uint64_t randomId() {
  std::random_device device;
  std::uniform_int_distribution<std::uint64_t> any(kSmallestId, kLargestId);
  return any(device);
}

}  // namespace handgraft
