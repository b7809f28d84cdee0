#include "server/admission/packed_reply.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

namespace handgraft::server {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

PackedReply::PackedReply(const v1::Reply& reply)
    : bytes_(v1::Reply::getCdrSerializedSize(reply)) {
  FastBuffer buffer(bytes_.data(), bytes_.size());
  Cdr cdr(buffer);
  reply.serialize(cdr);
  bytes_.resize(cdr.getSerializedDataLength());
  bytes_.shrink_to_fit();
}

v1::Reply PackedReply::open() const {
  // It is read only; Fast CDR has no buffer of constant bytes.
  FastBuffer buffer(const_cast<char*>(bytes_.data()), bytes_.size());
  Cdr cdr(buffer);
  v1::Reply reply;
  reply.deserialize(cdr);
  return reply;
}

}  // namespace handgraft::server
