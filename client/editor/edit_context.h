#pragma once

#include "idl/models.h"
#include "idl/sessions.h"

namespace handgraft::client::editor {

/// What a command may look up while it becomes an edit. Asked for only when it is needed:
/// behind it may be a server.
class EditContext {
 public:
  EditContext() = default;
  virtual ~EditContext() = default;
  EditContext(const EditContext&) = delete;
  EditContext& operator=(const EditContext&) = delete;

  virtual const v1::SessionSettings& settings() = 0;
  /// Without meshes.
  virtual const v1::HandDescription& hand() = 0;
  virtual const v1::HandDescription& handWithMeshes() = 0;
  virtual const v1::ObjectDescription& object() = 0;
  /// The last final one; nullptr: none yet.
  virtual const v1::PoseSolution* solution() = 0;
};

}  // namespace handgraft::client::editor
