#include "client/link/hand_side_edits.h"

namespace handgraft::client {

v1::EditBody rootEdit(const std::string& patch, const v1::SurfacePoint& root_S) {
  v1::PatchRootEdit edit;
  edit.patch(patch);
  edit.side(v1::SIDE_HAND);
  edit.root(root_S);
  v1::EditBody body;
  body.patch_root(edit);
  return body;
}

v1::EditBody directionEdit(const std::string& patch, double angle_rad) {
  v1::PatchDirectionEdit edit;
  edit.patch(patch);
  edit.side(v1::SIDE_HAND);
  edit.angle_rad(angle_rad);
  v1::EditBody body;
  body.patch_direction(edit);
  return body;
}

}  // namespace handgraft::client
