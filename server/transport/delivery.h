#pragma once

#include "server/transport/bus.h"

namespace eprosima::fastdds::dds {
class DataWriter;
}  // namespace eprosima::fastdds::dds

/// Who is sent what, beyond what Fast DDS' API offers; private to this folder.
namespace handgraft::server {

/// Heartbeats of a writer go to those readers alone who have not acknowledged something.
/// Without it one that was killed has all of them sent some, every 10 ms, until its lease ends;
/// each answers. `writer` must not have written yet.
void askThoseWhoOweAnAnswer(eprosima::fastdds::dds::DataWriter& writer);

/// Likewise each sample goes to the readers of one participant alone, the one that is named
/// while it is written; to nobody where none is.
void sendToOneAlone(eprosima::fastdds::dds::DataWriter& writer);

/// What this thread writes meanwhile to writers that send to one alone is for this one.
class WritingTo {
 public:
  explicit WritingTo(const Sender& whom);
  ~WritingTo();
  WritingTo(const WritingTo&) = delete;
  WritingTo& operator=(const WritingTo&) = delete;
};

}  // namespace handgraft::server
