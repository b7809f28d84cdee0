// hearing_client DOMAIN [IDENTITY]: asks once, says "asked"; at SIGUSR1 says how many answers
// came that it did not ask for, asks once more, and ends. Cyclone DDS shares what comes among
// all participants of a process: hence another process.
#include "tests/server/hearing_client.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <fmt/format.h>

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGUSR1);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    handgraft::Network network{std::atoi(argv[1]), "lo"};
    if (argc > 2) network.identity = argv[2];
    handgraft::test::HearingClient client(network);
    if (!client.ask(1)) return 1;
    client.heard();
    fmt::print("asked\n");
    std::fflush(stdout);
    int signal = 0;
    sigwait(&signals, &signal);
    fmt::print("heard {}\n", client.heard());
    return client.ask(2) ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "hearing_client: {}\n", error.what());
    return 1;
  }
}
