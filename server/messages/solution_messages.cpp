#include "server/messages/solution_messages.h"

#include <utility>

#include "core/base/error.h"
#include "core/verdict/verdicts.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

v1::Verdict toMessage(optimize::Verdict verdict) {
  switch (verdict) {
    case optimize::Verdict::kNone:
      return v1::VERDICT_NONE;
    case optimize::Verdict::kReached:
      return v1::VERDICT_REACHED;
    case optimize::Verdict::kAtLimit:
      return v1::VERDICT_AT_LIMIT;
    case optimize::Verdict::kOutOfReach:
      return v1::VERDICT_OUT_OF_REACH;
    case optimize::Verdict::kFacingWrong:
      return v1::VERDICT_NORMALS_IN_CONFLICT;
    case optimize::Verdict::kNoClearance:
      return v1::VERDICT_NO_CLEARANCE;
  }
  throw BrokenContract("a verdict that does not exist");
}

v1::LimitSensitivity toMessage(const hand::HandModel& model,
                               const optimize::LimitSensitivity& sensitivity) {
  v1::LimitSensitivity message;
  message.limit(limitOf(model.dofJoint(sensitivity.dof).name, sensitivity.upper));
  message.kind(kindOf(model.dofJoint(sensitivity.dof)));
  message.position(sensitivity.limit);
  message.slope(sensitivity.slope);
  message.given(sensitivity.given);
  message.gain(sensitivity.gain);
  message.gain_mm(sensitivity.gain_mm);
  return message;
}

}  // namespace

void diagnose(const session::Session& session,
              const optimize::PoseProblem& problem,
              const optimize::SolveReport& report,
              verdict::FitCheck& check,
              v1::PoseSolution& message,
              const Progress& progress) {
  message.penetration(
      {toMessage(*problem.model, verdict::penetrationOf(session, report.pose, progress))});
  progress.checkpoint();
  const verdict::FitFindings& findings = check.of(session, problem, &report);
  progress.checkpoint();
  const verdict::Verdicts verdicts = verdictsOf(session, problem, report, findings, progress);
  const hand::HandModel& model = *problem.model;
  const auto& patches = verdicts.diagnosis.patches;
  HANDGRAFT_REQUIRE(patches.size() <= message.patches().size());
  for (std::size_t k = 0; k < patches.size(); ++k) {
    v1::PatchDiagnosis one;
    one.verdict(toMessage(patches[k].verdict));
    one.miss_m(1e-3 * patches[k].miss_mm);
    one.facing_deg(patches[k].facing_deg);
    one.missing_clearance_m(patches[k].missing_clearance_m);
    one.alone_mm(patches[k].alone_mm);
    for (const optimize::LimitSensitivity& sensitivity : patches[k].sensitivities)
      one.sensitivities().push_back(toMessage(model, sensitivity));
    one.text(verdicts.texts[k]);
    message.patches()[k].diagnosis(std::move(one));
  }
  for (const optimize::LimitSensitivity& sensitivity : verdicts.diagnosis.sensitivities)
    message.sensitivities().push_back(toMessage(model, sensitivity));
  message.is_diagnosed(true);
  message.verdict(verdicts.line);
  message.too_large(verdicts.too_large);
  message.one_sided(verdicts.one_sided);
}

std::string checkSizesAhead(const session::Session& session, verdict::FitCheck& check) {
  return lineOf(session, check.of(session, session.problem()));
}

}  // namespace handgraft::server
