#pragma once

namespace CLI {
class App;
}  // namespace CLI

namespace handgraft::bench {

/// `motions`: recorded contact sequences followed by a hand, beside their author's own splines;
/// speed, and how it grows with the frames.
void addMotionsCommand(CLI::App& app);

}  // namespace handgraft::bench
