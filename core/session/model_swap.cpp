#include "core/session/model_swap.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/contact/reproject.h"
#include "core/geometry/tangent.h"
#include "core/session/patch_matching.h"
#include "core/session/patch_names.h"

namespace handgraft::session {
namespace {

/// Of each joint of `after` the one of that name; -1 where there is none.
std::vector<int> sourcesOf(const hand::HandModel& before, const hand::HandModel& after) {
  std::vector<int> source(static_cast<std::size_t>(after.dofCount()), -1);
  for (std::size_t i = 0; i < source.size(); ++i) {
    for (int dof = 0; dof < before.dofCount(); ++dof) {
      if (before.dofJoint(dof).name == after.dofJoint(static_cast<int>(i)).name)
        source[i] = dof;
    }
  }
  return source;
}

/// Whether a joint's limits are others than the hand's.
bool hasEditedLimits(const DocumentJoint& joint, const hand::HandModel& model, int dof) {
  return joint.lower != model.lower()[dof] || joint.upper != model.upper()[dof];
}

void keepLimits(const DocumentJoint& was,
                const std::string& name,
                DocumentJoint& joint,
                std::vector<std::string>& told) {
  if (was.lower >= joint.lower && was.upper <= joint.upper) {
    joint.lower = was.lower;
    joint.upper = was.upper;
    return;
  }
  told.push_back(
      fmt::format("limits of {} were dropped: {:.4g} to {:.4g} lie beyond the "
                  "hand's {:.4g} to {:.4g}",
                  name, was.lower, was.upper, joint.lower, joint.upper));
}

void keepSoftValue(const DocumentJoint& was,
                   const std::string& name,
                   DocumentJoint& joint,
                   std::vector<std::string>& told) {
  if (was.soft_value >= joint.lower && was.soft_value <= joint.upper) {
    joint.soft_weight = was.soft_weight;
    joint.soft_value = was.soft_value;
    return;
  }
  told.push_back(fmt::format("{} is no longer held at {:.4g}", name, was.soft_value));
}

/// The joints and the pose that still fit; says what does not.
void keepJoints(const Document& old,
                const hand::HandModel& before,
                const hand::HandModel& after,
                Document& document,
                std::vector<std::string>& told) {
  document.joints = jointsOf(after);
  const std::vector<int> source = sourcesOf(before, after);
  const bool keeps_pose = std::none_of(source.begin(), source.end(), [](int dof) {
    return dof < 0;
  });
  document.start = {};
  document.start.q = after.restPose();
  document.prior = document.start;
  document.start_is_known = keeps_pose && old.start_is_known;
  if (keeps_pose) {
    document.start.X_WH = old.start.X_WH;
    document.prior.X_WH = old.prior.X_WH;
  } else if (old.start_is_known) {
    told.push_back("the pose was dropped: the hand has other joints");
  }

  std::vector<char> is_kept(old.joints.size(), 0);
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (source[i] < 0) continue;
    const auto dof = static_cast<Eigen::Index>(i);
    const DocumentJoint& was = old.joints[static_cast<std::size_t>(source[i])];
    DocumentJoint& joint = document.joints[i];
    is_kept[static_cast<std::size_t>(source[i])] = 1;
    const std::string name = quoted(after.dofJoint(static_cast<int>(i)).name);
    if (hasEditedLimits(was, before, source[i])) keepLimits(was, name, joint, told);
    joint.locked = was.locked;
    if (was.soft_weight > 0.0) keepSoftValue(was, name, joint, told);
    if (!keeps_pose) continue;
    const auto moved = [&](double q) {
      return std::min(std::max(q, joint.lower), joint.upper);
    };
    document.start.q[dof] = moved(old.start.q[source[i]]);
    document.prior.q[dof] = moved(old.prior.q[source[i]]);
  }
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    const DocumentJoint& was = old.joints[i];
    const auto dof = static_cast<int>(i);
    const bool was_set =
        was.locked || was.soft_weight > 0.0 || hasEditedLimits(was, before, dof);
    if (is_kept[i] == 0 && was_set) {
      told.push_back(
          fmt::format("settings of joint {} were dropped: the hand has no such joint",
                      quoted(before.dofJoint(dof).name)));
    }
  }
}

bool haveSameTriangles(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b) {
  return a.vertexCount() == b.vertexCount() && a.faceCount() == b.faceCount() &&
         a.faces() == b.faces();
}

void addNotes(const std::vector<std::string>& told, Edited& edited) {
  constexpr std::size_t kMostNotes = 40;
  for (const std::string& note : told)
    edited.document.notes.push_back(note);
  if (edited.document.notes.size() > kMostNotes) edited.document.notes.resize(kMostNotes);
  edited.message = fmt::format("{}", fmt::join(told, "; "));
}

}  // namespace

Edited withHand(const Document& document,
                const std::string& name,
                ModelCache& cache,
                const Progress& progress) {
  const Models before = cache.find(document.hand, document.object, progress);
  const Models after = cache.find(name, document.object, progress);
  Edited edited{document, ""};
  Document& result = edited.document;
  std::vector<std::string> told;
  result.hand = name;
  result.notes = after.contacts->notes;
  keepJoints(document, *before.hand->model, *after.hand->model, result, told);

  const geometry::TriangleMesh& skin_S = after.hand->skin->mesh();
  const bool same_skin = haveSameTriangles(before.hand->skin->mesh(), skin_S);
  for (DocumentPatch& patch : result.patches) {
    if (patch.direction_is_open && !result.start_is_known) patch.direction_O.reset();
    if (same_skin && patch.placement) {
      patch.placement->direction_S =
          tangentAt(skin_S, patch.placement->root_S, patch.placement->direction_S)
              .value_or(anyTangentAt(skin_S, patch.placement->root_S));
      continue;
    }
    if (patch.placement && !patch.root_is_open && patch.site.empty())
      told.push_back(fmt::format("place of {} was dropped: the hand has another skin",
                                 quoted(patch.name)));
    patch.site.clear();
    patch.placement.reset();
    patch.dropped.clear();
    patch.root_is_open = false;
  }
  if (!same_skin && !result.held.empty()) {
    told.push_back("what was dragged is let go: the hand is another");
    result.held.clear();
  }
  matchPatches(after, result, progress);
  for (const DocumentPatch& patch : result.patches) {
    if (!patch.placement) told.push_back(patch.dropped);
  }
  addNotes(told, edited);
  return edited;
}

Edited withObject(const Document& document,
                  const std::string& name,
                  ModelCache& cache,
                  const Progress& progress) {
  const Models before = cache.find(document.hand, document.object, progress);
  const Models after = cache.find(document.hand, name, progress);
  Edited edited{document, ""};
  Document& result = edited.document;
  std::vector<std::string> told;
  result.object = name;
  result.notes = after.contacts->notes;
  result.patches.clear();
  for (const contact::Patch& outline : after.contacts->patches) {
    DocumentPatch patch;
    patch.name = outline.name;
    patch.weight = outline.weight;
    patch.root_O = outline.root;
    patch.direction_O = outline.direction_O;
    patch.direction_is_open = !outline.direction_O.has_value();
    for (const DocumentPatch& was : document.patches) {
      if (was.name != outline.name) continue;
      const geometry::SurfacePoint root = patch.root_O;
      patch = was;
      patch.root_O = root;
      // A direction of the contact set is carried with it; one that a user turned is laid onto
      // the new surface.
      const std::optional<Eigen::Vector3d> wanted = was.direction_O;
      if (patch.direction_is_open) {
        patch.direction_O.reset();
      } else if (wanted) {
        patch.direction_O = tangentAt(*after.object_O, root, *wanted)
                                .value_or(anyTangentAt(*after.object_O, root));
      }
    }
    result.patches.push_back(std::move(patch));
  }
  for (const DocumentPatch& was : document.patches) {
    const bool is_kept = std::any_of(result.patches.begin(), result.patches.end(),
                                     [&](const DocumentPatch& patch) {
                                       return patch.name == was.name;
                                     });
    if (!is_kept) {
      told.push_back(
          fmt::format("{} was dropped: it has no place on the object", quoted(was.name)));
    }
  }
  // === Roots that somebody edited
  for (DocumentPatch& patch : result.patches) {
    const auto was =
        std::find_if(document.patches.begin(), document.patches.end(), [&](const auto& one) {
          return one.name == patch.name;
        });
    if (was == document.patches.end()) continue;
    const contact::Patch original = patchOf(before, *was);
    const auto outline = std::find_if(before.contacts->patches.begin(),
                                      before.contacts->patches.end(), [&](const auto& one) {
                                        return one.name == patch.name;
                                      });
    const bool was_moved = outline->root.face != was->root_O.face ||
                           outline->root.barycentric != was->root_O.barycentric;
    if (!was_moved) continue;
    contact::ContactSet alone;
    alone.patches = {original};
    try {
      patch.root_O =
          contact::reproject(alone, *before.object_O, *after.object_O).patches.front().root;
      if (patch.direction_O) {
        patch.direction_O = tangentAt(*after.object_O, patch.root_O, *patch.direction_O)
                                .value_or(anyTangentAt(*after.object_O, patch.root_O));
      }
    } catch (const InvalidInput&) {
      told.push_back(
          fmt::format("root of {} is the contact set's again: the edited one has no "
                      "place on the object",
                      quoted(patch.name)));
    }
  }
  matchPatches(after, result, progress);
  addNotes(told, edited);
  return edited;
}

}  // namespace handgraft::session
