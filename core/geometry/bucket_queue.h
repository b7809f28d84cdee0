#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace handgraft::geometry {

/// A queue of numbered things by distance, in steps: those within one step of each other come
/// in any order, last in first out.
///
/// Cost: O(1) to put and take, and O(n) once every `kBuckets` steps.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): its copy's counter
class BucketQueue {
 public:
  struct Entry {
    double distance;
    int number;
  };

  /// `step` > 0, and no less than its inverse can tell (1e-308); or everything is one step.
  explicit BucketQueue(double step = 0.0)
      : inverse_step_(step >= std::numeric_limits<double>::min() ? 1.0 / step : 0.0) {}

  /// Up to here things belong to the step at hand.
  [[nodiscard]] double nearEnd() const { return near_end_; }

  /// Distances are finite, not negative.
  void put(double distance, int number) {
    const double step = (distance - begin_) * inverse_step_;
    if (step >= kBuckets) {
      later_.push_back({distance, number});
      return;
    }
    // Much nearer than the step at hand fits no int.
    buckets_[step > current_ ? static_cast<int>(step) : current_].push_back({distance, number});
  }

  /// Makes the next step that holds anything the one at hand; false if nothing is left.
  bool advance() {
    while (true) {
      for (; current_ < kBuckets; ++current_) {
        if (buckets_[current_].empty()) continue;
        near_end_ = inverse_step_ > 0.0 ? begin_ + (current_ + 1) / inverse_step_
                                        : std::numeric_limits<double>::infinity();
        return true;
      }
      if (later_.empty()) return false;
      rebase();
    }
  }

  /// Takes one thing of the step at hand; false if there is none left.
  bool take(Entry& entry) {
    std::vector<Entry>& bucket = buckets_[current_];
    if (bucket.empty()) return false;
    entry = bucket.back();
    bucket.pop_back();
    return true;
  }

  [[nodiscard]] double nearBegin() const {
    return inverse_step_ > 0.0 ? begin_ + current_ / inverse_step_ : 0.0;
  }

 private:
  static constexpr int kBuckets = 64;

  void rebase() {
    begin_ = std::min_element(later_.begin(), later_.end(), [](const Entry& a, const Entry& b) {
               return a.distance < b.distance;
             })->distance;
    current_ = 0;
    std::vector<Entry> all;
    all.swap(later_);
    for (const Entry& entry : all)
      put(entry.distance, entry.number);
  }

  double inverse_step_;
  double begin_ = 0.0;
  double near_end_ = 0.0;
  int current_ = 0;
  std::vector<Entry> buckets_[kBuckets];
  std::vector<Entry> later_;
};

}  // namespace handgraft::geometry
