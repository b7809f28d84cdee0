#include "server/handlers/problem.h"

#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/problem_file.h"

namespace handgraft::server {

v1::ExportProblemReply exportProblem(LiveSession& live,
                                     const v1::ExportProblemRequest& request,
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
  v1::ExportProblemReply reply;
  reply.text(io::problemText(solved ? *session.solvedProblem() : session.problem(),
                             request.urdf_path(), packages));
  return reply;
}

}  // namespace handgraft::server
