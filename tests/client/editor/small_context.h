#pragma once

#include "client/editor/edit_context.h"
#include "client/editor/grammar.h"

namespace handgraft::test {

/// A session on a hand of two links and two joints, one of which slides. The finger's link is a
/// tetrahedron whose tip is at (0, 0, 0.05) in its own frame; in the skin's frame the link
/// stands 0.1 m along x. Skin and object are a square of 1 m in the plane z = 0, in two faces.
class SmallContext : public client::editor::EditContext {
 public:
  SmallContext() {
    v1::Mesh square;
    square.vertices_m({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    square.triangles({0, 1, 2, 0, 2, 3});

    hand_.name("claw");
    v1::JointInfo bend;
    bend.name("bend");
    bend.lower(-1.0);
    bend.upper(2.0);
    v1::JointInfo slide;
    slide.name("slide");
    slide.kind(v1::JOINT_PRISMATIC);
    slide.upper(0.1);
    hand_.joints({bend, slide});
    hand_.rest_positions({0.25, 0.01});
    v1::LinkInfo base;
    base.name("base");
    v1::LinkInfo finger;
    finger.name("finger");
    finger.surface_L().vertices_m(
        {0, 0, 0.05F, 0.01F, 0, -0.01F, -0.01F, 0.01F, -0.01F, -0.01F, -0.01F, -0.01F});
    finger.surface_L().triangles({0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2});
    hand_.links({base, finger});
    v1::Pose here;
    here.q_wxyz({1, 0, 0, 0});
    v1::Pose along = here;
    along.p_m({0.1, 0, 0});
    hand_.X_SL({here, along});
    v1::SiteInfo pad;
    pad.name("index");
    pad.link("finger");
    pad.p_L_m({0.0, 0.2, 0.3});
    pad.direction_L({0, 0, -1});
    v1::SiteInfo palm;
    palm.name("palm");
    palm.link("base");
    palm.p_L_m({0.01, 0.02, 0.03});
    hand_.sites({pad, palm});
    hand_.skin_S(square);
    object_.name("plate");
    object_.mesh_O(square);

    settings_.X_WO().q_wxyz({0.6, 0.8, 0, 0});
    for (const v1::JointInfo& joint : hand_.joints()) {
      v1::JointSetting setting;
      setting.name(joint.name());
      setting.kind(joint.kind());
      setting.lower(-0.5);
      setting.upper(0.5);
      setting.model_lower(joint.lower());
      setting.model_upper(joint.upper());
      settings_.joints().push_back(setting);
    }
    settings_.solving().solver(v1::SOLVER_SLSQP);
    settings_.solving().starts(8);
    settings_.solving().seed(3);
  }

  const v1::SessionSettings& settings() override { return settings_; }

  const v1::HandDescription& hand() override { return hand_; }

  const v1::HandDescription& handWithMeshes() override { return hand_; }

  const v1::ObjectDescription& object() override { return object_; }

  const v1::PoseSolution* solution() override { return solved_ ? &solution_ : nullptr; }

  void solve(const v1::PoseSolution& solution) {
    solution_ = solution;
    solved_ = true;
  }

 private:
  v1::SessionSettings settings_;
  v1::HandDescription hand_;
  v1::ObjectDescription object_;
  v1::PoseSolution solution_;
  bool solved_ = false;
};

inline client::editor::Names smallNames() {
  client::editor::Names names;
  names.patches = {"thumb", "index"};
  names.joints = {"bend", "slide"};
  names.followers = {{"bend_2", "bend"}};
  names.sites = {"index", "palm"};
  names.points = {"index", "index_tip", "palm", "palm_tip", "base", "finger"};
  names.hands = {"allegro16", "barrett8"};
  names.objects = {"box", "lemon"};
  names.snapshots = {"before"};
  names.sessions = {"3", "12"};
  return names;
}

}  // namespace handgraft::test
