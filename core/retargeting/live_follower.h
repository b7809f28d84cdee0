#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/hand/finger_coordinates.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/contact_tracker.h"
#include "core/optimize/solve_report.h"
#include "core/placement/open_roots.h"
#include "core/quality/penetration.h"
#include "core/retargeting/going_along.h"
#include "core/retargeting/live_beginning.h"
#include "core/retargeting/live_fingers.h"
#include "core/retargeting/live_glitches.h"
#include "core/retargeting/live_searches.h"
#include "core/retargeting/live_way.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::retargeting {

/// A hand that follows a demonstrator's, frame by frame as they come: where parts of the
/// demonstrator's hand touch the object, the same parts of this hand do (ContactTracker), by
/// the causal solver, within limits and out of the object. Touches come and go within 60 ms.
/// A hand of other proportions cannot show all of them where they are meant: places yield,
/// along the link that they are on, to where the hand shows the touch, and touches that it
/// cannot show, to those that it can: each weighs 1 / (1 + (d / 12.5 mm)^2), d how far off it
/// is (Cauchy's weight). Where the hand lacks a finger that touches, they are dealt out anew
/// (session/dealing.h).
///
/// A hand that is 12 mm off on average for a quarter of a second is lost: it is searched in the
/// same way again, and where that is nearer by far it goes there, about the object, in 0.8 s at
/// most. So it is where a finger has touched for as long and none of the hand's shows it, and
/// where it is more than 2 mm inside the object.
///
/// While nothing touches it goes as the demonstrator's hand does over the object (GoingAlong):
/// away, open, and back to the same or to another place.
///
/// It begins when three parts or more touch and no more come, or two fingers pinch
/// (LiveBeginning): the best pose of
/// that frame alone, from many starts, where these leave it open held as the demonstrator's
/// hand is. After
/// a pause of 0.25 s, or where time has run backwards by as much, it goes on from where the
/// hand is, at rest. One frame or two in which a joint jumps as no finger moves are passed
/// over: what touched before them touches still. Deterministic. Cost: some tenths of a
/// millisecond a frame, tens of milliseconds once.
class LiveFollower {
 public:
  static constexpr int kTouchesToBegin = LiveBeginning::kTouchesToBegin;

  /// What counts of the document: as in solveMotion, but for what it says of patches.
  /// Errors: Cancelled on wish.
  LiveFollower(const session::Document& document,
               const hand::Hand& hand,
               std::shared_ptr<const geometry::TriangleMesh> object_O,
               const Progress& progress);
  LiveFollower(const LiveFollower&) = delete;  // its solver refers to its problem
  LiveFollower& operator=(const LiveFollower&) = delete;

  /// How a part of the hand meets what the demonstrator touches with it.
  struct PartFit {
    int part = 0;  ///< as the touches number it
    Eigen::Vector3d on_hand_W = Eigen::Vector3d::Zero();
    Eigen::Vector3d on_object_W = Eigen::Vector3d::Zero();
    double distance_mm = 0.0;
    double facing_deg = 0.0;
    bool reached = false;  ///< as of optimize::isReached
  };

  struct Answer {
    hand::HandPose pose;         ///< in W: the hand's base where the object is now
    int touches = 0;             ///< of the demonstrator
    bool is_on_its_way = false;  ///< to a better pose, which was found elsewhere
    double objective = 0.0;
    int evaluations = 0;
    std::vector<PartFit> parts;  ///< of these touches that have a place on this hand
    quality::Depths depths;
    std::vector<optimize::ActiveLimit> limits;
  };

  /// Nothing before it has begun. Errors: InvalidInput, and nothing changes, for a time that
  /// does not lie behind the last one's and for what is not finite.
  std::optional<Answer> follow(const manipulation::DemonstratedFrame& frame,
                               const Progress& progress);

  /// The same of touches that somebody else has found, whose numbers of parts they bear: one
  /// follower is told by one of them alone. Frames: X_WO in W; X_OD is the demonstrator's hand
  /// in O, of which only the motion counts; not known: while nothing touches, the hand stays
  /// over the object.
  std::optional<Answer> follow(double time_s,
                               const Pose& X_WO,
                               const std::vector<manipulation::DetectedContact>& touches,
                               const std::vector<contact::PartDirection>& posture,
                               const Progress& progress,
                               const std::optional<Pose>& X_OD = {});

  /// Of the demonstrator's last frame.
  [[nodiscard]] int touches() const { return static_cast<int>(seen_.size()); }

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

  /// How well the hand shows what touches now.
  struct Standing {
    double lack = 0.0;      ///< of touches: 1 - trust of each, of fingers that it lacks 1
    int shown = 0;          ///< touches that have a place on the hand
    double distance = 0.0;  ///< m, on average over those
  };

  /// m; so deep nobody holds an object.
  static constexpr double kDeep = 0.002;

  class Attempt;
  struct Search;

  void requireLater(double time_s) const;
  std::vector<char> comeAndGo(const std::vector<manipulation::DetectedContact>& touches,
                              double fade);
  void meet(const manipulation::DetectedContact& touch);
  void slide(double share);
  void meetAnew();
  static double trustIn(double distance);
  [[nodiscard]] optimize::PointPair pairOf(std::size_t index) const;
  std::optional<hand::LinkPoint> spotOf(const manipulation::DetectedContact& touch);
  [[nodiscard]] optimize::PoseProblem problemNow() const;
  std::optional<hand::HandPose> leaveFor(const std::vector<contact::PartDirection>& posture,
                                         const Pose& X_OD);
  [[nodiscard]] optimize::PoseProblem problemTo(const hand::HandPose& goal_O) const;
  void dealAnew(const std::vector<contact::PartDirection>& posture, const Progress& progress);
  [[nodiscard]] std::vector<std::string> touchingDigits() const;
  [[nodiscard]] int partsTouching() const;
  void takeFingers();
  bool begin(double time_s,
             const std::vector<contact::PartDirection>& posture,
             const Progress& progress);
  /// Leaves what it finds in last_O_; how deep that is in the object, m.
  double search(const std::vector<contact::PartDirection>& posture,
                const Search& how,
                const Progress& progress);
  void lookAnew(double time_s,
                double step_s,
                const std::vector<contact::PartDirection>& posture,
                const Progress& progress);
  [[nodiscard]] Standing standing() const;
  [[nodiscard]] double depthNow(const Progress& progress) const;
  [[nodiscard]] std::vector<PartFit> fitsOf(
      const std::vector<manipulation::DetectedContact>& touches, const Pose& X_WO) const;

  hand::Hand hand_;
  std::shared_ptr<const geometry::TriangleMesh> object_O_;
  hand::FingerCoordinates coordinates_;
  manipulation::MotionProblem problem_;
  manipulation::MotionOptions options_;
  manipulation::ContactTracker tracker_;
  manipulation::CausalSolver solver_;
  std::shared_ptr<const placement::SkinFaces> faces_;
  Eigen::Vector3d middle_O_;  // of the object
  std::vector<TouchingPart> parts_;
  LiveFingers fingers_;
  std::vector<manipulation::DetectedContact> seen_;  // in the last frame
  std::map<PlaceKey, std::optional<hand::LinkPoint>> spots_;
  LiveGlitches glitches_;
  std::optional<double> last_s_;
  std::optional<hand::HandPose> last_O_;  // once it has begun
  double depth_ = 0.0;                    // m, of the last answer in the object
  LiveBeginning beginning_;
  LiveSearches searches_;
  std::optional<GoingAlong> along_;
  std::size_t most_seen_ = 0;   ///< touches, since something touches
  std::optional<LiveWay> way_;  // to a better pose that was found far from the hand
};

}  // namespace handgraft::retargeting
