#pragma once

#include <string>
#include <vector>

#include "server/store/database.h"

namespace handgraft::server {

/// Of the files that this program writes.
inline constexpr int kStateSchema = 3;

/// Errors: InvalidInput naming the file if it is of a newer program.
void requireSchema(Database& database);

/// Brings a file of an earlier schema, or a new one, to ours, one step in a transaction.
/// Errors: as requireSchema; StorageError, the step not done then.
void bringToSchema(Database& database);

/// What is wrong with a file of our schema, a line each (StateStore::check).
std::vector<std::string> problemsOf(Database& database);

}  // namespace handgraft::server
