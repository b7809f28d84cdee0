#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `scaling DIR`: the same problems with 10 to 10,000 points.
void addScalingCommand(CLI::App& app);

/// `placements DIR`: problems from favourable starts and from many poor ones.
void addPlacementsCommand(CLI::App& app);

/// `pairs OUT`: problems of many hands and contacts, written and solved from the files.
void addPairsCommand(CLI::App& app);

/// `tables`: the paper's Tables I and II, and how we fare.
void addTablesCommand(CLI::App& app);

}  // namespace handgraft::bench
