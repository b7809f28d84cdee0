#include "server/handlers/export.h"

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/grasp_writer.h"
#include "core/io/problem_file.h"
#include "core/io/scene_writer.h"
#include "server/handlers/optimize.h"

namespace handgraft::server {

namespace {

std::string problemOf(LiveSession& live,
                      const v1::ExportRequest& request,
                      const Progress& progress) {
  if (request.package_names().size() != request.package_paths().size()) {
    rejectInput("export: {} package names but {} paths", request.package_names().size(),
                request.package_paths().size());
  }
  std::vector<std::pair<std::string, std::string>> packages;
  for (std::size_t i = 0; i < request.package_names().size(); ++i) {
    packages.emplace_back(request.package_names()[i], request.package_paths()[i]);
  }
  session::Session& session = live.session();
  const bool solved = session.solvedProblem() && live.solved_revision == session.revision();
  if (!solved) session.transferPatches(progress);
  const optimize::PoseProblem problem = solved ? *session.solvedProblem() : session.problem();
  std::vector<std::string> notes;
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

Standing standingOf(LiveSession& live, Workshop& workshop, const Progress& progress) {
  session::Session& session = live.session();
  if (session.needsSolve()) optimizeAfterEdit(live, workshop, progress);
  const session::Document& document = session.document();
  if (!document.start_is_known) {
    rejectInput("export: session {} has no pose yet; solve it first", live.id());
  }
  Standing standing;
  standing.solution = session.standing(progress);
  standing.grasp.hand = document.hand;
  standing.grasp.object = document.object;
  standing.grasp.model = session.hand().model;
  standing.grasp.object_O = session.shelf().object(document.object, progress);
  standing.grasp.pose = standing.solution.report.pose;
  standing.grasp.X_WO = document.X_WO;
  return standing;
}

std::string jsonOf(const Standing& standing) {
  io::SolvedGrasp solved{standing.solution.report, {}};
  for (const session::SessionPatch& patch : standing.solution.patches)
    solved.patch_names.push_back(patch.patch.name);
  return io::graspJson(standing.grasp, &solved);
}

std::string contentOf(LiveSession& live,
                      const v1::ExportRequest& request,
                      Workshop& workshop,
                      const Progress& progress) {
  using Writer = std::string (*)(const Standing&);
  static const std::map<std::string, Writer, std::less<>> kWriters = {
      {"json", jsonOf},
      {"csv",
       [](const Standing& one) {
         return io::jointCsv(one.grasp);
       }},
      {"obj",
       [](const Standing& one) {
         return io::objText(one.grasp);
       }},
      {"glb",
       [](const Standing& one) {
         return io::glbBytes(one.grasp);
       }},
      {"isaac_grasp", [](const Standing& one) {
         return io::isaacGraspYaml(one.grasp, io::confidenceOf(one.solution.report));
       }}};
  if (request.format() == "problem") return problemOf(live, request, progress);
  const auto writer = kWriters.find(request.format());
  if (writer == kWriters.end()) {
    rejectInput(
        "export: there is no format {}; there are json, csv, obj, glb, isaac_grasp, problem",
        quoted(request.format()));
  }
  return writer->second(standingOf(live, workshop, progress));
}

}  // namespace

v1::ExportReply exportSession(LiveSession& live,
                              const v1::ExportRequest& request,
                              Workshop& workshop,
                              const Progress& progress) {
  const std::string content = contentOf(live, request, workshop, progress);
  v1::ExportReply reply;
  reply.content().assign(content.begin(), content.end());
  return reply;
}

}  // namespace handgraft::server
