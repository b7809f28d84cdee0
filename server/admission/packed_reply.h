#pragma once

#include <vector>

#include "idl/service.h"

namespace handgraft::server {

/// A reply as it goes over the wire: a Reply in memory has room for every kind of answer, some
/// 4 kB of which most use a hundred bytes.
class PackedReply {
 public:
  explicit PackedReply(const v1::Reply& reply);

  [[nodiscard]] v1::Reply open() const;

  bool operator==(const PackedReply&) const = default;

 private:
  std::vector<char> bytes_;
};

}  // namespace handgraft::server
