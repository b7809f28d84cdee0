#pragma once

#include <memory>
#include <vector>

#include "core/geometry/log_mapper.h"
#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

/// A hand ready for use; shared by all sessions.
struct Hand {
  std::shared_ptr<const HandModel> model;
  std::shared_ptr<const Skin> skin;
  std::vector<ContactSite> sites;
  /// Log maps of the skin, so that sessions share what those keep; a session makes its own
  /// where it is missing.
  std::shared_ptr<const geometry::LogMapper> skin_maps = nullptr;
  /// Nobody chose the sites: they say which finger, and where on it only roughly. Patches on
  /// them may slide.
  bool sites_are_found = false;
};

}  // namespace handgraft::hand
