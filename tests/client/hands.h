#pragma once

#include <array>
#include <string>

#include "idl/models.h"

/// Descriptions as a server might send them.
namespace handgraft::test {

inline v1::Pose poseAt(double x, double y, double z) {
  v1::Pose X;
  X.p_m() = {x, y, z};
  X.q_wxyz() = {1.0, 0.0, 0.0, 0.0};
  return X;
}

/// A closed box, outward, with corners `low` and `high`.
inline v1::Mesh box(std::array<float, 3> low, std::array<float, 3> high) {
  v1::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      mesh.vertices_m().push_back((i >> k) % 2 == 0 ? low[k] : high[k]);
  }
  mesh.triangles() = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                      2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

inline v1::SiteInfo site(const std::string& name,
                         const std::string& link,
                         std::array<double, 3> p_L,
                         std::array<double, 3> n_L,
                         std::array<double, 3> direction_L) {
  v1::SiteInfo info;
  info.name(name);
  info.link(link);
  info.p_L_m() = p_L;
  info.n_L() = n_L;
  info.direction_L() = direction_L;
  return info;
}

/// A flat palm in the x-y plane with two straight fingers along +y and a thumb along +x, whose
/// pads face +z. Its skin is the palm's box.
inline v1::HandDescription flatHand() {
  v1::HandDescription hand;
  hand.name("flat");
  const auto link = [&](const std::string& name, const v1::Mesh& mesh, double x, double y) {
    v1::LinkInfo info;
    info.name(name);
    info.surface_L() = mesh;
    hand.links().push_back(info);
    hand.X_SL().push_back(poseAt(x, y, 0.0));
  };
  link("palm", box({-0.04F, -0.05F, -0.01F}, {0.04F, 0.05F, 0.01F}), 0.0, 0.0);
  const v1::Mesh finger = box({-0.008F, 0.0F, -0.008F}, {0.008F, 0.06F, 0.008F});
  link("index_tip", finger, 0.02, 0.05);
  link("middle_tip", finger, -0.02, 0.05);
  link("thumb_tip", box({0.0F, -0.008F, -0.008F}, {0.05F, 0.008F, 0.008F}), 0.04, 0.0);
  hand.sites() = {site("thumb", "thumb_tip", {0.04, 0, 0.008}, {0, 0, 1}, {-1, 0, 0}),
                  site("index", "index_tip", {0, 0.05, 0.008}, {0, 0, 1}, {0, -1, 0}),
                  site("middle", "middle_tip", {0, 0.05, 0.008}, {0, 0, 1}, {0, -1, 0}),
                  site("palm", "palm", {0, 0, 0.01}, {0, 0, 1}, {0, -1, 0})};
  hand.sites_found(true);
  hand.sites_file("format: handgraft-sites/1\n");
  for (const char* name : {"index_mcp", "slide"}) {
    v1::JointInfo joint;
    joint.name(name);
    joint.parent_link("palm");
    joint.child_link("index_tip");
    joint.lower(-0.25);
    joint.upper(1.5);
    hand.joints().push_back(joint);
  }
  hand.joints()[1].kind(v1::JOINT_PRISMATIC);
  hand.rest_positions() = {0.0, 0.01};
  hand.skin_S() = hand.links()[0].surface_L();
  hand.skin_face_links().assign(12, 0);
  hand.skin_face_links()[3] = 1;
  hand.skin_face_links()[4] = -1;
  v1::SkinReport report;
  report.valid(true);
  report.closed(true);
  report.pieces(1);
  report.vertices(8);
  report.faces(12);
  report.text("wrap alpha 3 mm: kept\n8 vertices");
  report.steps().resize(1);
  report.steps()[0].action("wrap");
  hand.skin_report().push_back(report);
  return hand;
}

/// One patch on a box: a square on its top.
inline v1::ContactsDescription squareOnBox() {
  v1::ContactsDescription set;
  set.name("box_1");
  set.object("box");
  v1::PatchInfo patch;
  patch.name("index");
  patch.root().face(2);  // of the top, z = 0.05
  patch.root().barycentric() = {0.0, 0.5, 0.5};
  patch.direction_O() = {1.0, 0.0, 0.0};
  patch.point_count(4);
  patch.weight(1.0);
  patch.outline_O_m() = {-0.02, -0.02, 0.05, 0.02,  -0.02, 0.05,
                         0.02,  0.02,  0.05, -0.02, 0.02,  0.05};
  set.patches().push_back(patch);
  set.file(R"({"format": "handgraft-contacts/1"})");
  set.notes().emplace_back("dropped nothing");
  return set;
}

inline v1::ObjectDescription boxObject() {
  v1::ObjectDescription object;
  object.name("box");
  object.mesh_O() = box({-0.05F, -0.05F, -0.05F}, {0.05F, 0.05F, 0.05F});
  return object;
}

}  // namespace handgraft::test
