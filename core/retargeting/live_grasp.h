#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/hand/finger_coordinates.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/contact_tracker.h"
#include "core/manipulation/motion_options.h"
#include "core/manipulation/motion_problem.h"
#include "core/optimize/pose_problem.h"
#include "core/placement/open_roots.h"
#include "core/retargeting/live_fingers.h"
#include "core/session/document.h"

namespace handgraft::retargeting {

/// What a hand that follows live, and the object, are: the same from frame to frame, and safe
/// from several threads.
struct LiveSetting {
  /// What counts of the document: as in solveMotion, but for what it says of patches.
  /// Errors: Cancelled on wish.
  LiveSetting(const session::Document& document,
              const hand::Hand& hand,
              std::shared_ptr<const geometry::TriangleMesh> object_O,
              const Progress& progress);

  hand::Hand hand;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  std::shared_ptr<const hand::FingerCoordinates> coordinates;
  manipulation::MotionProblem problem;
  manipulation::MotionOptions options;
  std::shared_ptr<const placement::SkinFaces> faces;
  Eigen::Vector3d middle_O;                   ///< of the object
  std::vector<std::vector<int>> dofs_moving;  ///< each link
};

/// How a hand in a pose shows what a demonstrator touches: which of its fingers each touch has,
/// and where on them. A copy is another way to show the same, so a search may try one.
///
/// A hand of other proportions cannot show all touches where they are meant: places yield,
/// along the link that they are on, to where the hand shows the touch, and touches that it
/// cannot show, to those that it can: each weighs 1 / (1 + (d / 12.5 mm)^2), d how far off it
/// is (Cauchy's weight).
class LiveGrasp {
 public:
  /// How a part of the hand meets what the demonstrator touches with it.
  struct PartFit {
    int part = 0;  ///< as the touches number it
    Eigen::Vector3d on_hand_W = Eigen::Vector3d::Zero();
    Eigen::Vector3d on_object_W = Eigen::Vector3d::Zero();
    double distance_mm = 0.0;
    double facing_deg = 0.0;
    bool reached = false;  ///< as of optimize::isReached
  };

  /// How well the hand shows what touches now.
  struct Standing {
    double lack = 0.0;      ///< of touches: 1 - trust of each, of fingers that it lacks 1
    int shown = 0;          ///< touches that have a place on the hand
    double distance = 0.0;  ///< m, on average over those
  };

  /// Of no touches, in no pose.
  explicit LiveGrasp(std::shared_ptr<const LiveSetting> setting);

  [[nodiscard]] const LiveSetting& setting() const { return *setting_; }

  // === What touches

  /// From now on these touch. Of what comes and goes no more than `fade` in this frame. Of a
  /// hand in a pose, digits that have come since fingers were dealt are given theirs.
  void comeAndGo(const std::vector<manipulation::DetectedContact>& touches, double fade);
  /// Touches as `other` has them now, by the fingers and places that this one has.
  void goOnFrom(const LiveGrasp& other);

  [[nodiscard]] const std::vector<manipulation::DetectedContact>& seen() const { return seen_; }

  [[nodiscard]] int touches() const { return static_cast<int>(seen_.size()); }

  /// What still fades counts.
  [[nodiscard]] bool isTouching() const;
  /// Of the demonstrator, thumb to little.
  [[nodiscard]] std::vector<std::string> touchingDigits() const;
  /// Of each joint, whether it moves a part that shows a touch.
  [[nodiscard]] std::vector<char> holdingJoints() const;
  /// Digits, and the palm.
  [[nodiscard]] int partsTouching() const;

  // === Who shows it

  [[nodiscard]] const LiveFingers& fingers() const { return fingers_; }

  /// Deals them so while what touches now does, and forgets how touches were shown.
  void deal(session::Dealing dealing);
  /// No finger is dealt to anyone.
  void letGo();
  /// As they are dealt; forgets how touches were shown.
  void meetAnew();
  /// As they are dealt, while what touches now does: nothing better is known.
  void keepFingers();

  // === Where the hand is, in O

  std::optional<hand::HandPose> pose_O;

  /// Moves places to where the hand, in its pose, shows what is touched, by this share of the
  /// way, and trust to what it shows.
  void slide(double share);
  /// The frame's Eq. 2, with a pair a touch, from the hand's pose or, without one, its prior.
  [[nodiscard]] optimize::PoseProblem problem() const;
  /// Of these touches that have a place on the hand. The hand has a pose.
  [[nodiscard]] std::vector<PartFit> fitsOf(
      const std::vector<manipulation::DetectedContact>& touches, const Pose& X_WO) const;
  [[nodiscard]] Standing standing() const;

 private:
  /// What a part touches, and where on this hand.
  struct TouchingPart {
    double presence = 0.0;
    std::string digit;                     // the demonstrator's
    std::optional<hand::LinkPoint> meant;  // none: this part has no place on the hand
    Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
    Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
    /// From there to where the hand shows the touch, on the same link.
    Eigen::Vector3d slide_L = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn_L = Eigen::Vector3d::Zero();
    double trust = 1.0;  ///< less, the farther the hand is from showing it

    [[nodiscard]] Eigen::Vector3d shownPlace() const;  ///< on its link; it has a place
    void forget();                                     ///< how it was shown
  };

  /// A part's place as it is kept for later frames, rounded to what a hand's skin tells apart.
  struct PlaceKey {
    std::string finger;
    int part = 0;
    int along = 0;
    int around = 0;
    int across = 0;

    auto operator<=>(const PlaceKey&) const = default;  // NOLINT(modernize-use-nullptr): its 0
  };

  void takeFingers();
  void meet(const manipulation::DetectedContact& touch);
  std::optional<hand::LinkPoint> spotOf(const manipulation::DetectedContact& touch);
  [[nodiscard]] optimize::PointPair pairOf(std::size_t index) const;

  std::shared_ptr<const LiveSetting> setting_;
  std::vector<TouchingPart> parts_;
  LiveFingers fingers_;
  std::vector<manipulation::DetectedContact> seen_;  // in the last frame
  std::map<PlaceKey, std::optional<hand::LinkPoint>> spots_;
};

}  // namespace handgraft::retargeting
