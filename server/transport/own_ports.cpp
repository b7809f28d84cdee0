#include "server/transport/own_ports.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>

namespace handgraft::server {

namespace fs = std::filesystem;

namespace {

/// Inodes of this process' sockets, as its open files name them: "socket:[123]".
std::set<std::string> ownSockets() {
  std::set<std::string> sockets;
  const std::string begin = "socket:[";
  std::error_code error;
  for (auto at = fs::directory_iterator("/proc/self/fd", error);
       !error && at != fs::directory_iterator(); at.increment(error)) {
    std::error_code gone;
    const std::string name = fs::read_symlink(at->path(), gone).string();
    if (!gone && name.rfind(begin, 0) == 0)
      sockets.insert(name.substr(begin.size(), name.size() - begin.size() - 1));
  }
  return sockets;
}

}  // namespace

std::optional<std::set<unsigned>> portsHeard(int domain) {
  constexpr unsigned kBegin = 7400;
  constexpr unsigned kOfADomain = 250;
  constexpr unsigned kFirst = 10;  // below it are the groups'
  const unsigned begin = kBegin + kOfADomain * static_cast<unsigned>(domain);
  std::ifstream table("/proc/self/net/udp");
  std::string line;
  if (!std::getline(table, line)) return std::nullopt;
  const std::set<std::string> own = ownSockets();
  std::set<unsigned> ports;
  while (std::getline(table, line)) {
    // Number, local and remote address, state, queues, timer, retransmissions, user, timeout,
    // inode.
    std::istringstream words(line);
    std::string local;
    std::string inode;
    std::string skipped;
    words >> skipped >> local >> skipped >> skipped >> skipped >> skipped >> skipped >>
        skipped >> skipped >> inode;
    const std::size_t colon = local.find(':');
    if (!words || colon == std::string::npos || own.count(inode) == 0) continue;
    const auto port = static_cast<unsigned>(std::stoul(local.substr(colon + 1), nullptr, 16));
    if (port >= begin + kFirst && port < begin + kOfADomain) ports.insert(port);
  }
  return ports;
}

}  // namespace handgraft::server
