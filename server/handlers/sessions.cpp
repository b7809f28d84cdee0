#include "server/handlers/sessions.h"

#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "server/convert.h"
#include "server/rejection.h"
#include "server/transfer_messages.h"

namespace handgraft::server {

namespace {

/// An object that was taken out and loaded again is the same one.
bool sameMesh(const io::MeshFile& a, const io::MeshFile& b) {
  return &a == &b ||
         (a.mesh.vertexCount() == b.mesh.vertexCount() &&
          a.mesh.faceCount() == b.mesh.faceCount() && a.mesh.faces() == b.mesh.faces() &&
          a.mesh.vertices() == b.mesh.vertices());
}

}  // namespace

v1::SessionState openSession(const v1::OpenSessionRequest& request,
                             Workshop& workshop,
                             const Progress& progress) {
  const auto hand = workshop.models.hand(request.hand());
  const auto object = workshop.models.object(request.object());
  const auto contacts = workshop.models.contacts(request.contacts());
  if (!sameMesh(*contacts->object, *object->file)) {
    rejectInput("contacts {} were read for object {}, which is another mesh than object {}",
                handgraft::quoted(request.contacts()), handgraft::quoted(contacts->set.object),
                handgraft::quoted(request.object()));
  }
  const Pose X_WO = poseFrom(request.X_WO(), "X_WO");
  const optimize::Weights weights = weightsFrom(request.weights());
  const transfer::TransferOptions transfer = transferOptionsFrom(request.transfer());

  const auto begin = std::chrono::steady_clock::now();
  session::Hand ready = hand->hand->get(progress);
  const std::chrono::duration<double, std::milli> skin =
      std::chrono::steady_clock::now() - begin;
  // The session sees the mesh alone; the file that holds it stays with it.
  const std::shared_ptr<const geometry::TriangleMesh> mesh_O(object->file, &object->file->mesh);
  session::Session session(std::move(ready), mesh_O, contacts->set, X_WO, weights, transfer);
  progress.checkpoint();

  auto live = std::make_shared<LiveSession>(
      workshop.sessions.reserve(),
      SessionNames{request.hand(), request.object(), request.contacts()}, std::move(session),
      workshop.pool, workshop.audience);
  live->skin_ms = skin.count();
  workshop.sessions.add(live);
  live->enter(v1::PHASE_OPEN);
  return live->state();
}

v1::SessionState describeSession(const v1::SessionKey& key, const Workshop& workshop) {
  return workshop.sessions.find(key.session_id())->state();
}

v1::SessionList listSessions(const Workshop& workshop) {
  v1::SessionList reply;
  for (const auto& live : workshop.sessions.all())
    reply.sessions().push_back(live->state());
  return reply;
}

void closeSession(LiveSession& live, Workshop& workshop) {
  workshop.sessions.remove(live.id());
  live.enter(v1::PHASE_CLOSED);
}

}  // namespace handgraft::server
