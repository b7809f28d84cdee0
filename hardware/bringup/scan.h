#pragma once

#include <string>
#include <vector>

namespace handgraft::bringup {

/// A device that answered.
struct Found {
  std::string kind;  ///< as in a config: "dynamixel", "ability_hand", "odrive"
  int baud = 0;      ///< of the tty
  int id = -1;       ///< Dynamixel id, ODrive node, or a hand's address
  std::string what;  ///< for people: its model, what it tells
};

/// Who answers on a tty: Dynamixel motors at each of their rates, an Ability Hand, ODrive axes
/// behind an SLCAN adapter. Asks only what moves nothing and changes nothing; an adapter is
/// told to open its bus. Takes some seconds. Errors: TransportError if the port cannot be
/// opened.
std::vector<Found> scan(const std::string& port);

/// A line each, and how to go on; of nothing, what may be the matter.
std::string scanText(const std::string& port, const std::vector<Found>& found);

}  // namespace handgraft::bringup
