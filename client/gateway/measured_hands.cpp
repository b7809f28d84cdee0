#include "client/gateway/measured_hands.h"

#include "idl/topics.h"

namespace handgraft::client::gateway {

void MeasuredHands::take(const std::function<void(const v1::JointState&)>& use) {
  const auto now = client_.participant();
  if (participant_ != now) {  // the network was joined anew
    rest();
    reader_ =
        std::make_unique<idl::cyclone::Reader<v1::JointState>>(*now, idl::kJointStateTopic);
    participant_ = now;
  }
  std::map<std::uint32_t, v1::JointState> newest;
  reader_->take([&](const v1::JointState& state) {
    if (state.session_id() != 0) newest[state.bridge_id()] = state;
  });
  for (const auto& [bridge, state] : newest)
    use(state);
}

void MeasuredHands::rest() {
  reader_.reset();
  participant_.reset();
}

}  // namespace handgraft::client::gateway
