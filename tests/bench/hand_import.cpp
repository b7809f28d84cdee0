#include "tests/bench/hand_import.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/hand/contact_site.h"
#include "core/hand/digits.h"
#include "core/hand/kinematics.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"

#include "tests/bench/dart_poses.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace fs = std::filesystem;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double angleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

/// Sites that a person wrote for this hand, if there are any.
std::vector<hand::ContactSite> givenSites(const fs::path& urdf, const hand::HandModel& model) {
  const fs::path file = urdf.parent_path() / "sites.yaml";
  if (!fs::exists(file)) return {};
  return io::readSites(file, model);
}

/// In space, at the skin's reference pose: the two may be on neighbouring links.
double distanceToGiven(const hand::ContactSite& site,
                       const std::vector<hand::ContactSite>& given,
                       const hand::HandModel& model,
                       const hand::LinkPoses& X_SL) {
  const auto place = [&](const hand::ContactSite& s) {
    return Eigen::Vector3d(X_SL[static_cast<std::size_t>(model.linkIndex(s.link))] * s.p_L);
  };
  for (const hand::ContactSite& other : given)
    if (other.name == site.name) return 1e3 * (place(site) - place(other)).norm();
  return kNone;
}

void measureSites(const hand::HandModel& model, const hand::Skin& skin, HandImport& import) {
  hand::LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  const hand::Digits found = findDigits(model, X_SL);
  import.digits = static_cast<int>(found.digits.size());
  Eigen::Vector3d all_closing = Eigen::Vector3d::Zero();
  for (const hand::Digit& digit : found.digits)
    all_closing += digit.closing;

  const std::vector<hand::ContactSite> given = givenSites(import.path, model);
  for (const hand::ContactSite& site : findContactSites(model, skin)) {
    const int link = model.linkIndex(site.link);
    Eigen::Vector3d closing = all_closing;
    for (const hand::Digit& digit : found.digits)
      if (std::find(digit.tip_links.begin(), digit.tip_links.end(), link) !=
          digit.tip_links.end())
        closing = digit.closing;
    FoundSite row;
    row.name = site.name;
    row.link = site.link;
    row.off_closing_deg =
        angleDeg(X_SL[static_cast<std::size_t>(link)].linear() * site.n_L, closing);
    row.to_given_mm = distanceToGiven(site, given, model, X_SL);
    import.sites.push_back(row);
  }
}

}  // namespace

int HandImport::sitesOnTheBack() const {
  return static_cast<int>(std::count_if(sites.begin(), sites.end(), [](const FoundSite& s) {
    return s.off_closing_deg > 90.0;
  }));
}

int HandImport::pads() const {
  return static_cast<int>(std::count_if(sites.begin(), sites.end(), [](const FoundSite& s) {
    return s.name != "palm";
  }));
}

HandImport importHand(const fs::path& urdf, int poses) {
  HandImport import;
  import.path = urdf;
  import.name = urdf.stem().string();
  try {
    const double begin = threadMilliseconds();
    const io::UrdfFile file = io::readUrdf(urdf);
    import.read_s = 1e-3 * (threadMilliseconds() - begin);
    const hand::HandModel& model = file.model;
    import.name = model.name();
    import.links = model.linkCount();
    import.dofs = model.dofCount();
    import.mimics = model.mimicCount();
    import.root_dofs = file.floating_base ? file.floating_base->dofCount() : 0;
    import.notes = file.notes;
    import.pose_difference = largestPoseDifference(
        urdf, io::readUrdfKinematics(urdf, io::FloatingBase::kKept), poses);

    const double unwrapped = threadMilliseconds();
    const hand::Skin skin = buildSkin(model, hand::SkinOptions(), Progress(), &import.skin);
    import.skin_s = 1e-3 * (threadMilliseconds() - unwrapped);
    measure(skin, import.skin);
    measureSites(model, skin, import);
  } catch (const InvalidInput& error) {
    import.refused = error.what();
  }
  return import;
}

std::vector<fs::path> urdfsIn(const std::vector<std::string>& folders) {
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    if (!fs::is_directory(folder)) rejectInput("{} is no folder", quoted(folder));
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().extension() == ".urdf")
        files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace handgraft::bench
