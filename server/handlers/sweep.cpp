#include "server/handlers/sweep.h"

#include <chrono>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/sweep/sweep.h"
#include "server/messages/convert.h"
#include "server/messages/study_messages.h"
#include "server/messages/transfer_messages.h"

namespace handgraft::server {

namespace {

sweep::SweepGrasp graspFrom(const v1::SweepGrasp& grasp, const Workshop& workshop) {
  const auto object = workshop.models.object(grasp.object());
  const auto contacts = workshop.models.contacts(grasp.contacts());
  requireSameMesh(*contacts, *object);
  return {{object->file, &object->file->mesh}, contacts->set};
}

}  // namespace

v1::SweepReply sweepHand(const v1::SweepRequest& request,
                         Workshop& workshop,
                         const Progress& progress) {
  const auto hand = workshop.models.hand(request.hand());
  std::vector<sweep::SweepGrasp> grasps;
  for (const v1::SweepGrasp& grasp : request.grasps())
    grasps.push_back(graspFrom(grasp, workshop));
  std::vector<sweep::SweepAxis> axes;
  for (const v1::SweepAxis& axis : request.axes())
    axes.push_back(axisFrom(axis));
  sweep::SweepOptions options;
  options.solving = solvingFrom(request.options());
  options.weights = weightsFrom(request.weights());
  options.transfer = transferOptionsFrom(request.transfer());

  const hand::Hand ready = hand->hand->get(progress);
  const Workshop::Share share(workshop);
  options.threads = share.threads();
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<sweep::SweepRow> rows =
      sweep::sweep(ready, grasps, axes, options, progress);
  const std::chrono::duration<double, std::milli> spent =
      std::chrono::steady_clock::now() - begin;

  v1::SweepReply reply;
  reply.joint_names(ready.model->dofNames());
  reply.rows().reserve(rows.size());
  for (const sweep::SweepRow& row : rows)
    reply.rows().push_back(toMessage(row));
  reply.total_ms(spent.count());
  return reply;
}

}  // namespace handgraft::server
