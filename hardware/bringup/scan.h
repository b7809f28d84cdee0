#pragma once

#include <string>
#include <vector>

namespace handgraft::bringup {

/// A device that answered.
struct Found {
  std::string kind;     ///< as in a config
  int baud = 0;         ///< of the tty; 0: there is none
  int can_bitrate = 0;  ///< of the bus behind it; 0: none, or not known
  int id = -1;          ///< Dynamixel id, ODrive node, or a hand's address
  std::string what;     ///< for people: its model, what it tells
};

/// Who answers on a tty: Dynamixel motors at each of their rates, an Ability Hand, an Inspire
/// hand, ODrive axes or an Allegro Hand behind an SLCAN adapter; and who is on a CAN bus, whose
/// network interface is no path. Asks only what moves nothing and changes nothing; an adapter
/// is told to open its bus. Takes some seconds. Errors: TransportError if the port cannot be
/// opened.
std::vector<Found> scan(const std::string& port);

/// A line each, and how to go on; of nothing, what may be the matter.
std::string scanText(const std::string& port, const std::vector<Found>& found);

}  // namespace handgraft::bringup
