#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace handgraft::geometry {

/// Numbers what it is asked for in the order in which it is asked: keys of a whole mesh become
/// places in arrays that grow with the disk alone.
///
/// Cost: expected O(1) a call (open addressing), nothing that depends on the range of the keys.
class IndexMap {
 public:
  explicit IndexMap(int expected = 512) {
    while (slots_.size() < 2 * static_cast<std::size_t>(expected))
      grow();
  }

  [[nodiscard]] int size() const { return static_cast<int>(keys_.size()); }

  [[nodiscard]] int keyOf(int number) const { return keys_[static_cast<std::size_t>(number)]; }

  /// The number of a key (not negative), or -1.
  [[nodiscard]] int find(int key) const { return slots_[slotOf(key)].number; }

  /// The number of a key, a new one if it has none; `second` tells whether it is new.
  std::pair<int, bool> add(int key) {
    Slot& slot = slots_[slotOf(key)];
    if (slot.number >= 0) return {slot.number, false};
    const int number = size();
    slot = {key, number};
    keys_.push_back(key);
    if (2 * keys_.size() > slots_.size()) grow();
    return {number, true};
  }

 private:
  struct Slot {
    int key = -1;
    int number = -1;
  };

  /// Where the key is or belongs.
  [[nodiscard]] std::size_t slotOf(int key) const {
    // Fibonacci hashing: neighbours in a mesh often have neighbouring numbers.
    std::size_t slot = (static_cast<std::uint32_t>(key) * 2654435769U) >> shift_;
    while (slots_[slot].number >= 0 && slots_[slot].key != key)
      slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }

  void grow() {
    --shift_;
    slots_.assign(2 * slots_.size(), Slot{});
    for (int number = 0; number < size(); ++number)
      slots_[slotOf(keyOf(number))] = {keyOf(number), number};
  }

  int shift_ = 31;  ///< 32 minus the slots' number of bits
  std::vector<Slot> slots_{2};
  std::vector<int> keys_;
};

}  // namespace handgraft::geometry
