#pragma once

#include <array>
#include <string_view>

namespace handgraft::bench {

/// One entry of the paper's Tables I and II: mean over three placements, on a Xeon W-1250.
struct PaperFigure {
  double seconds = 0.0;  ///< of all optimisation calls; 0: not available
  double edits = 0.0;    ///< of the prior, by a user, on the way
};

struct PaperRow {
  std::string_view hand;                  ///< ours that stands for the paper's
  std::string_view theirs;                ///< with its degrees of freedom
  std::array<PaperFigure, 4> favourable;  ///< of 3, 4, 5, 6 patches
  std::array<PaperFigure, 4> poor;
};

/// Source: Lakshmipathy, Bauer, Bauer & Pollard, "Contact Transfer", Tables I and II.
inline constexpr std::array<PaperRow, 4> kPaperRows = {{
    {"human20",
     "human hand (26)",
     {{{0.688, 0.0}, {0.884, 0.33}, {0.422, 1.0}, {1.036, 1.0}}},
     {{{1.115, 0.0}, {1.752, 0.67}, {1.406, 1.33}, {2.032, 2.33}}}},
    {"allegro16",
     "Allegro hand (22)",
     {{{0.135, 0.0}, {0.303, 0.0}, {0.278, 1.0}, {}}},
     {{{0.397, 0.0}, {0.721, 0.67}, {0.522, 1.0}, {}}}},
    {"barrett8",
     "Barrett hand (13)",
     {{{0.081, 0.0}, {0.089, 0.0}, {}, {}}},
     {{{0.137, 0.0}, {0.183, 0.0}, {}, {}}}},
    {"tendon16",
     "prosthetic (22)",
     {{{0.288, 0.0}, {0.346, 0.33}, {0.284, 0.67}, {0.394, 1.0}}},
     {{{0.441, 0.0}, {1.443, 0.67}, {0.564, 1.33}, {1.267, 1.67}}}},
}};

}  // namespace handgraft::bench
