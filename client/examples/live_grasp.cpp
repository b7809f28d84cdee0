/// A live session from a program of one's own: a grasp is solved, one joint is locked, and the
/// poses that follow are told as they come. Takes the DDS domain; where no server answers
/// there, one is started for this program.

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <handgraft/client.h>

namespace client = handgraft::client;
namespace v1 = handgraft::v1;

namespace {

int run(int argc, char** argv) {
  client::ClientOptions options;
  options.network.domain = argc > 1 ? std::atoi(argv[1]) : 0;
  options.absence = client::Absence::kStartPrivate;
  client::Client server(options);

  // Several calls at once: each is on its way when it returns.
  auto models = server.listModels();
  v1::OpenSessionRequest request;
  request.hand("barrett8");
  request.object("lemon");
  request.contacts("lemon_6");
  auto opened = server.openSession(request);
  std::printf("%zu models\n", models.get().models().size());

  client::Session session(server, opened.get());
  std::atomic<int> samples{0};
  const client::Following following(server, session.id(),
                                    {.on_solution = [&](const v1::PoseSolution&) {
                                      ++samples;
                                    }});
  const v1::PoseSolution first = session.solve().get();
  for (const v1::PatchFit& patch : first.patches()) {
    std::printf("%s: %.1f mm\n", patch.name().c_str(), patch.mean_mm());
  }

  v1::JointLockEdit lock;
  lock.joint(session.state().joint_names().at(0));
  lock.locked(true);
  v1::EditBody edit;
  edit.joint_lock(lock);
  const v1::EditReply reply = session.edit(edit).get();
  const v1::PoseSolution* pose = session.awaitFinal(reply.revision());
  session.close().get();
  if (pose == nullptr) return 1;
  std::printf("revision %llu: objective %.4f, %d poses on the stream\n",
              static_cast<unsigned long long>(pose->revision()), pose->terms().objective(),
              samples.load());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
