#pragma once

namespace handgraft::retargeting {

/// When a hand that follows is searched anew: it has been lost, or has lacked a finger that
/// touches, for a quarter of a second.
///
/// A search takes tens of milliseconds, which frames do not have. Where one found nothing
/// better the next waits twice as long, from 0.5 s to 4 s: some hands cannot show what is
/// touched.
class LiveSearches {
 public:
  /// How it is in a frame that comes `step_s` after the one before.
  void see(double step_s, bool is_lost, bool is_unserved);

  [[nodiscard]] bool isDue(double time_s) const;

  void foundNothing(double time_s);

  /// Something better, where the hand is at `end_s`.
  void found(double end_s);

  /// What touches has changed, and with it what a search may find.
  void touchesChanged() { wait_s_ = kShortestWait; }

  /// Behind a pause.
  void beginAnew(double time_s);

 private:
  static constexpr double kShortestWait = 0.5;

  double lost_s_ = 0.0;      // how long it has missed what is touched
  double unserved_s_ = 0.0;  // how long a finger has touched that none shows
  double not_before_s_ = 0.0;
  double wait_s_ = kShortestWait;
};

}  // namespace handgraft::retargeting
