#include "core/session/step_stack.h"

#include "core/session/field_bytes.h"

namespace handgraft::session {

StepStack::SharedStep StepStack::at(std::size_t place) const {
  FieldReader bytes(*steps_.at(place));
  auto step = std::make_shared<HistoryStep>();
  bytes.read(step->label);
  bytes.read(step->change);
  return step;
}

void StepStack::pushBack(const HistoryStep& step) {
  FieldWriter bytes;
  bytes.add(step.label);
  bytes.add(step.change);
  steps_.push_back(std::make_shared<const std::string>(bytes.take()));
}

}  // namespace handgraft::session
