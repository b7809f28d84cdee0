#include "core/session/patch_names.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/hand/hand_location.h"

namespace handgraft::session {

namespace {

// By hand: a pattern matcher of the library recurses once a character.
bool isAnonymous(const std::string& name, char letter) {
  return name.size() > 1 && name.front() == letter &&
         std::all_of(name.begin() + 1, name.end(), [](char c) {
           return c >= '0' && c <= '9';
         });
}

}  // namespace

bool isAnonymousPatch(const std::string& name) {
  return isAnonymous(name, 'c');
}

bool isAnonymousSite(const std::string& name) {
  return isAnonymous(name, 'f');
}

bool isFinger(const std::string& name) {
  static const std::vector<std::string> digit_names = {"thumb", "index", "middle", "ring",
                                                       "little"};
  return std::find(digit_names.begin(), digit_names.end(), name) != digit_names.end();
}

std::string namesOf(const std::vector<hand::ContactSite>& sites) {
  if (sites.empty()) return "none: a sites.yaml beside the URDF gives it some";
  std::vector<std::string> names;
  names.reserve(sites.size());
  for (const hand::ContactSite& site : sites)
    names.push_back(site.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

void validateSet(const contact::ContactSet& set,
                 const geometry::TriangleMesh& object_O,
                 const std::vector<hand::ContactSite>& sites) {
  if (set.patches.empty()) rejectInput("contact set {} has no patch", quoted(set.name));
  std::vector<std::string> names;
  for (const contact::Patch& patch : set.patches) {
    validate(object_O, patch);
    if (std::find(names.begin(), names.end(), patch.name) != names.end()) {
      rejectInput("contact set {} names patch {} twice", quoted(set.name), quoted(patch.name));
    }
    names.push_back(patch.name);
    const bool is_site = std::any_of(sites.begin(), sites.end(), [&](const auto& site) {
      return site.name == patch.name;
    });
    if (!is_site && !isFinger(patch.name) && !isAnonymousPatch(patch.name) &&
        !isAnonymousSite(patch.name) && !patch.place && !hand::placeNamed(patch.name)) {
      rejectInput(
          "contact set {}: patch {} names no site; permitted are thumb, index, middle, ring, "
          "little, palm, a finger's segment (index_proximal), c1, c2, ... and this hand's "
          "sites "
          "({})",
          quoted(set.name), quoted(patch.name), namesOf(sites));
    }
  }
}

}  // namespace handgraft::session
