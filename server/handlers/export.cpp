#include "server/handlers/export.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/io/grasp_writer.h"
#include "core/io/problem_file.h"
#include "core/io/row_writer.h"
#include "core/io/scene_writer.h"
#include "core/placement/pregrasp.h"
#include "idl/fields.h"
#include "idl/grasp_file.h"
#include "server/handlers/motions.h"
#include "server/handlers/optimize.h"
#include "server/handlers/solving_phase.h"
#include "server/messages/convert.h"
#include "server/messages/session_messages.h"
#include "server/messages/solution_messages.h"
#include "server/messages/transfer_messages.h"

namespace handgraft::server {

namespace {

std::string problemOf(LiveSession& live,
                      const v1::ExportRequest& request,
                      const Progress& progress,
                      std::vector<std::string>& notes) {
  if (request.package_names().size() != request.package_paths().size()) {
    rejectInput("export: {} package names but {} paths", request.package_names().size(),
                request.package_paths().size());
  }
  std::vector<std::pair<std::string, std::string>> packages;
  for (std::size_t i = 0; i < request.package_names().size(); ++i) {
    packages.emplace_back(request.package_names()[i], request.package_paths()[i]);
  }
  session::Session& session = live.session();
  const bool solved = session.solvedProblem() && live.cycle().isSolvedAt(session.revision());
  if (!solved) session.transferPatches(progress);
  const optimize::PoseProblem problem = solved ? *session.solvedProblem() : session.problem();
  if (problem.avoidance != nullptr) {
    notes.emplace_back(
        "depth inside the object and the hand itself was charged, too, which this file cannot "
        "say");
  }
  return io::problemText(problem, request.urdf_path(), packages, notes);
}

/// The hand as it stands once every edit is answered, and how well it fits.
struct Standing {
  io::PosedGrasp grasp;
  session::Solution solution;
};

Standing standingOf(LiveSession& live, const Progress& progress) {
  session::Session& session = live.session();
  const session::Document& document = session.document();
  if (!document.start_is_known) {
    rejectInput("export: session {} has no pose yet; solve it first", live.id());
  }
  Standing standing;
  standing.solution = session.standing(progress);
  standing.grasp.hand = document.hand;
  standing.grasp.object = document.object;
  standing.grasp.model = session.hand().model;
  standing.grasp.object_O = session.cache().object(document.object, progress);
  standing.grasp.pose = standing.solution.report.pose;
  standing.grasp.X_WO = document.X_WO;
  return standing;
}

/// The pose that answers the session, with the terms of its search; judged anew where nobody
/// knows them any more.
v1::PoseSolution diagnosedPose(LiveSession& live, const Progress& progress) {
  if (const v1::PoseSolution* diagnosed = live.diagnosed()) return *diagnosed;
  const session::Session& session = live.session();
  if (const auto pose = live.cycle().undiagnosed()) {
    v1::PoseSolution solution = pose->message;
    diagnose(session, pose->problem, pose->report, live.fit_check, solution, progress);
    return solution;
  }
  const Standing standing = standingOf(live, progress);
  v1::PoseSolution solution =
      solutionMessage(session, standing.solution.problem, standing.solution.report);
  solution.session_id(live.id());
  solution.revision(session.revision());
  solution.options(toMessage(session.document().solving));
  solution.chosen_minimum(static_cast<std::uint32_t>(session.chosenMinimum()));
  diagnose(session, standing.solution.problem, standing.solution.report, live.fit_check,
           solution, progress);
  return solution;
}

std::string jsonOf(LiveSession& live, const Progress& progress) {
  const session::Session& session = live.session();
  const hand::HandModel& model = *session.hand().model;
  const session::Document& document = session.document();
  idl::GraspNames names{document.hand,
                        document.object,
                        document.contacts,
                        {},
                        {},
                        weightsMessage(document.weights)};
  for (int dof = 0; dof < model.dofCount(); ++dof)
    names.joints.push_back(model.dofJoint(dof).name);
  for (const hand::Link& link : model.links())
    names.links.push_back(link.name);
  const v1::PoseSolution solution = diagnosedPose(live, progress);
  return idl::graspText(names, solution, patchReports(session));
}

/// Where the patches are that count, and which of them are reached.
io::ContactRows contactsOf(LiveSession& live, const Standing& one, const Progress& progress) {
  const v1::PoseSolution solution = diagnosedPose(live, progress);
  const auto& patches = live.session().patches();
  io::ContactRows contacts;
  for (const v1::PatchFit& fit : solution.patches()) {
    const auto item =
        std::find_if(patches.begin(), patches.end(), [&](const session::SessionPatch& each) {
          return each.patch.name == fit.name();
        });
    if (item == patches.end()) continue;
    contacts.patch_names.push_back(fit.name());
    const bool is_reached = fit.diagnosis().verdict() == v1::VERDICT_REACHED;
    contacts.presence.push_back(is_reached ? 1.0 : 0.0);
    const Eigen::Vector3d p_W =
        one.grasp.X_WO * positionOf(*one.grasp.object_O, item->patch.root);
    contacts.p_W_m.insert(contacts.p_W_m.end(), p_W.data(), p_W.data() + 3);
  }
  return contacts;
}

std::string isaacGraspOf(LiveSession& live,
                         const Standing& one,
                         const Progress& progress,
                         std::vector<std::string>& notes) {
  const placement::Pregrasp before =
      placement::pregraspOf(live.session().hand(), one.grasp.object_O, one.grasp.X_WO,
                            one.grasp.pose, one.solution.problem.pairs, progress);
  if (!before.is_clear) {
    notes.push_back(
        fmt::format("no pose before the grasp was found that is clear of the object: the hand "
                    "is {:.1f} mm inside at pregrasp_cspace_position",
                    1e3 * before.depth_m));
  }
  return io::isaacGraspYaml(one.grasp, io::confidenceOf(one.solution.report), before.q, notes);
}

/// It shows the pose that answers the last edit.
bool isOfPoses(v1::ExportFormat format) {
  return format != v1::EXPORT_PROBLEM;
}

std::string contentOf(LiveSession& live,
                      const v1::ExportRequest& request,
                      const Progress& progress,
                      std::vector<std::string>& notes) {
  if (request.live()) return liveRunExport(live, request.format(), notes);
  if (live.motion() != nullptr) return motionExport(live, request.format());
  switch (request.format()) {
    case v1::EXPORT_JSON:
      return jsonOf(live, progress);
    case v1::EXPORT_CSV:
      return io::jointCsv(standingOf(live, progress).grasp);
    case v1::EXPORT_OBJ:
      return io::objText(standingOf(live, progress).grasp);
    case v1::EXPORT_GLB:
      return io::glbBytes(standingOf(live, progress).grasp);
    case v1::EXPORT_ISAAC_GRASP: {
      const Standing one = standingOf(live, progress);
      return isaacGraspOf(live, one, progress, notes);
    }
    case v1::EXPORT_PROBLEM:
      return problemOf(live, request, progress, notes);
    case v1::EXPORT_NPZ: {
      const Standing one = standingOf(live, progress);
      return io::npzOf(io::rowsOf(one.grasp), contactsOf(live, one, progress));
    }
    case v1::EXPORT_MJCF: {
      const io::PosedGrasp grasp = standingOf(live, progress).grasp;
      return io::mjcfOf(io::rowsOf(grasp),
                        fmt::format("{} grasps {}", grasp.hand, grasp.object), "grasp");
    }
    case v1::EXPORT_ROS_TRAJECTORY:
      return io::rosTrajectoryYaml(io::rowsOf(standingOf(live, progress).grasp));
  }
  rejectInput("export: there is no format {}; there are {}",
              static_cast<unsigned>(request.format()),
              fmt::join(idl::namesOf(idl::typeOf<v1::ExportFormat>()), ", "));
}

}  // namespace

std::optional<v1::ExportReply> exportSession(LiveSession& live,
                                             const v1::ExportRequest& request,
                                             HandlerContext& context,
                                             const Progress& progress) {
  if (!request.live() && isOfPoses(request.format()) && live.motion() == nullptr &&
      live.session().needsSolve()) {
    const SolveEnd end = solveAsItStands(live, context, progress);
    if (end == SolveEnd::kCutShort) return std::nullopt;
    requireDone(end, live);
  }
  v1::ExportReply reply;
  const std::string content = contentOf(live, request, progress, reply.notes());
  if (!request.live() && live.motion() != nullptr && !live.following.run.isEmpty())
    reply.notes().emplace_back(
        "the motion as it was solved; what the hand did live, after a demonstrator, is another "
        "export (live)");
  reply.content().assign(content.begin(), content.end());
  return reply;
}

}  // namespace handgraft::server
