#include "server/handlers/sweep.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/retargeting/motion_solving.h"
#include "core/sweep/sweep.h"
#include "server/messages/convert.h"
#include "server/messages/study_messages.h"
#include "server/messages/transfer_messages.h"

namespace handgraft::server {

namespace {

/// What a request's row is about: a grasp of the sweep, and which patch of a motion.
struct Asked {
  std::size_t grasp = 0;
  bool is_motion = false;
  std::string patch;  ///< empty: all of them
};

/// The grasps and motions of a request, each motion once however many of its patches are asked
/// for.
class Studied {
 public:
  Studied(const v1::SweepRequest& request, const HandlerContext& context) {
    for (const v1::SweepGrasp& grasp : request.grasps()) {
      const auto object = context.models.object(grasp.object());
      if (grasp.motion().empty())
        addContacts(*context.models.contacts(grasp.contacts()), object);
      else
        addMotion(*context.models.motion(grasp.motion()), object, grasp.contacts());
    }
  }

  [[nodiscard]] const std::vector<sweep::SweepGrasp>& grasps() const { return grasps_; }

  [[nodiscard]] const std::vector<Asked>& asked() const { return asked_; }

 private:
  void addContacts(const StoredContacts& contacts,
                   const std::shared_ptr<const StoredObject>& object) {
    requireSameMesh(contacts, *object);
    asked_.push_back({grasps_.size(), false, {}});
    grasps_.push_back({{object->file, &object->file->mesh}, contacts.set, nullptr});
  }

  void addMotion(const StoredMotion& motion,
                 const std::shared_ptr<const StoredObject>& object,
                 const std::string& patch) {
    requireSameMesh(motion, *object);
    const std::vector<std::string> names = retargeting::patchNames(*motion.motion);
    if (!patch.empty() && std::find(names.begin(), names.end(), patch) == names.end())
      rejectInput("sweep: motion {} has no patch {}; it has {}", handgraft::quoted(motion.name),
                  handgraft::quoted(patch), fmt::join(names, ", "));
    const auto [known, is_new] =
        motions_.try_emplace({motion.motion.get(), object.get()}, grasps_.size());
    asked_.push_back({known->second, true, patch});
    if (is_new) grasps_.push_back({{object->file, &object->file->mesh}, {}, motion.motion});
  }

  std::vector<sweep::SweepGrasp> grasps_;
  std::vector<Asked> asked_;
  std::map<std::pair<const void*, const void*>, std::size_t> motions_;
};

}  // namespace

v1::SweepReply sweepHand(const v1::SweepRequest& request,
                         HandlerContext& context,
                         const Progress& progress) {
  const auto hand = context.models.hand(request.hand());
  const Studied studied(request, context);
  std::vector<sweep::SweepAxis> axes;
  for (const v1::SweepAxis& axis : request.axes())
    axes.push_back(axisFrom(axis));
  sweep::SweepOptions options;
  options.solving = solverSettingsFrom(request.options());
  options.weights = weightsFrom(request.weights());
  options.transfer = transferOptionsFrom(request.transfer());

  double asked = static_cast<double>(studied.asked().size());
  for (const sweep::SweepAxis& axis : axes)
    asked *= static_cast<double>(axis.values.size());
  if (asked > static_cast<double>(sweep::kMostSweepRows))
    rejectInput(
        "sweep: {} grasps and patches of motions with these values are {:.0f} rows; at "
        "most {} are permitted",
        studied.asked().size(), asked, sweep::kMostSweepRows);

  const hand::Hand ready = hand->hand->get(progress);
  const HandlerContext::Share share(context);
  options.threads = share.threads();
  const auto begin = std::chrono::steady_clock::now();
  const sweep::SweepResult swept =
      sweep::sweep(ready, studied.grasps(), axes, options, progress);
  const std::chrono::duration<double, std::milli> spent =
      std::chrono::steady_clock::now() - begin;

  v1::SweepReply reply;
  reply.joint_names(ready.model->dofNames());
  const std::size_t grasps = studied.grasps().size();
  for (std::size_t first = 0; first < swept.rows.size(); first += grasps) {
    for (std::size_t i = 0; i < studied.asked().size(); ++i) {
      const Asked& one = studied.asked()[i];
      const sweep::SweepRow& row = swept.rows[first + one.grasp];
      v1::SweepRow message = one.is_motion ? toMessage(row, one.patch) : toMessage(row);
      message.grasp(static_cast<std::uint32_t>(i));
      reply.rows().push_back(std::move(message));
    }
  }
  for (std::size_t i = 0; i < studied.asked().size(); ++i) {
    for (const std::string& text : swept.notes[studied.asked()[i].grasp]) {
      v1::SweepNote note;
      note.grasp(static_cast<std::uint32_t>(i));
      note.text(text);
      reply.notes().push_back(std::move(note));
    }
  }
  reply.total_ms(spent.count());
  return reply;
}

}  // namespace handgraft::server
