#include "client/gateway/web_request.h"

#include <arpa/inet.h>

namespace handgraft::client::gateway {
namespace {

/// The time it takes does not tell how much of a guess is right.
bool sameSecret(const std::string& secret, const std::string& guess) {
  unsigned difference = secret.size() == guess.size() ? 0U : 1U;
  for (std::size_t i = 0; i < guess.size(); ++i) {
    const char expected = secret.empty() ? '\0' : secret[i % secret.size()];
    difference |= static_cast<unsigned char>(expected ^ guess[i]);
  }
  return difference == 0 && !secret.empty();
}

/// "localhost" of "localhost:8080"; "[::1]" of "[::1]:8080".
std::string hostName(const std::string& host) {
  const std::size_t colon =
      host.find(':', host.find(']') == std::string::npos ? 0 : host.find(']'));
  return host.substr(0, colon);
}

}  // namespace

bool isLoopback(const std::string& address) {
  in_addr four{};
  in6_addr six{};
  if (inet_pton(AF_INET, address.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24 == 127;
  if (inet_pton(AF_INET6, address.c_str(), &six) == 1) return IN6_IS_ADDR_LOOPBACK(&six);
  return address == "localhost";
}

std::string pathOf(const std::string& target) {
  return target.substr(0, target.find('?'));
}

std::string parameterOf(const std::string& target, const std::string& name) {
  std::size_t at = target.find('?');
  while (at != std::string::npos) {
    const std::size_t end = target.find('&', at + 1);
    const std::string pair =
        target.substr(at + 1, end == std::string::npos ? end : end - at - 1);
    if (pair.rfind(name + "=", 0) == 0) return pair.substr(name.size() + 1);
    at = end;
  }
  return {};
}

std::string firstWord(const std::string& target) {
  constexpr std::size_t kLongest = 20;  // digits
  const std::string session = parameterOf(target, "session");
  if (session.empty() || session.size() > kLongest ||
      session.find_first_not_of("0123456789") != std::string::npos)
    return {};
  return R"({"id":1,"do":"show","session":)" + session + "}";
}

bool isHostKnown(const std::string& address, const std::string& host) {
  if (!isLoopback(address)) return true;
  const std::string name = hostName(host);
  return name == "localhost" || name == "127.0.0.1" || name == "[::1]" || name == address;
}

bool isOriginKnown(const std::string& host, const std::string& origin) {
  return origin.empty() || origin == "http://" + host || origin == "https://" + host;
}

std::optional<Rights> rightsOf(const WebOptions& options, const std::string& target) {
  Rights rights = Rights::kEdit;
  if (!options.edit_token.empty() || !options.look_token.empty()) {
    const std::string token = parameterOf(target, "token");
    if (sameSecret(options.look_token, token)) {
      rights = Rights::kLook;
    } else if (!sameSecret(options.edit_token, token)) {
      return std::nullopt;
    }
  }
  return options.read_only ? Rights::kLook : rights;
}

}  // namespace handgraft::client::gateway
