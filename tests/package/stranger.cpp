// A grasp in twenty lines, of a program that knows Handgraft by its package alone.
#include <cstdio>
#include <cstdlib>

#include <handgraft/client.h>

int main(int argc, char** argv) {
  using namespace handgraft;
  client::ClientOptions options;
  options.network.domain = argc > 1 ? std::atoi(argv[1]) : 0;
  options.absence = client::Absence::kStartPrivate;
  client::Client server(options);
  v1::OpenSessionRequest request;
  request.hand("barrett8");
  request.object("lemon");
  request.contacts("lemon_6");
  client::Session session(server, server.openSession(request).get());
  const v1::PoseSolution pose = session.solve().get();
  std::printf("%s\n", pose.verdict().c_str());
  session.close().get();
}
