#include "server/handlers/export.h"

#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/problem_file.h"

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
  return io::problemText(solved ? *session.solvedProblem() : session.problem(),
                         request.urdf_path(), packages);
}

}  // namespace

v1::ExportReply exportSession(LiveSession& live,
                              const v1::ExportRequest& request,
                              const Progress& progress) {
  if (request.format() != "problem") {
    rejectInput("export: there is no format {}; there is problem", quoted(request.format()));
  }
  const std::string text = problemOf(live, request, progress);
  v1::ExportReply reply;
  reply.content().assign(text.begin(), text.end());
  return reply;
}

}  // namespace handgraft::server
