#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "core/base/network.h"
#include "core/base/resource_uri.h"
#include "idl/models.h"

/// The commands of `handgraft`, one file each. A command prints to standard output, notices to
/// standard error, and returns the exit code; errors leave as exceptions for main.cpp.
namespace handgraft::client {

class Interruption;

/// Options of every command.
struct CommonOptions {
  Network network;
  bool json = false;  ///< exactly one JSON document on standard output (`watch`: one a line)
};

struct DoctorOptions {};

struct ModelsOptions {
  struct Show {
    v1::ModelKind kind = v1::MODEL_HAND;
    std::string name;
  };

  std::optional<Show> show;  ///< nothing: the list
};

struct LoadOptions {
  v1::ModelKind kind = v1::MODEL_HAND;
  std::filesystem::path path;
  std::string name;    ///< empty: from the path
  std::string object;  ///< contacts alone
  PackageMap packages;
};

struct GraspOptions {
  std::string hand;  ///< a model's name, or a path; likewise the next two
  std::string object;
  std::string contacts;
  std::optional<std::array<double, 7>> place;    ///< X_WO: x y z in m, qw qx qy qz
  std::optional<std::array<double, 3>> weights;  ///< distance (1/m^2), normal, prior
  std::string solver;
  std::uint32_t starts = 0;
  std::uint32_t seed = 0;
  std::string log_map;               ///< empty: the server's default
  std::uint32_t interior_rings = 0;  ///< of correspondences besides the boundary's
  std::filesystem::path out;         ///< empty: not written; likewise the next two
  std::filesystem::path png;
  std::filesystem::path problem;
  PackageMap packages;
  bool keep = false;
};

struct SessionsOptions {};

struct TransferOptions {
  std::uint64_t session_id = 0;
};

struct SuggestOptions {
  std::uint64_t session_id = 0;
  std::string patch;
  double reach_mm = 0.0;  ///< 0: the server's default; likewise the next
  std::uint32_t count = 0;
  std::uint32_t apply = 0;  ///< the suggestion to apply, from 1; 0: none
};

struct CloseOptions {
  std::uint64_t session_id = 0;
};

struct UnloadOptions {
  v1::ModelKind kind = v1::MODEL_HAND;
  std::string name;
};

struct WatchOptions {
  std::uint64_t session_id = 0;
  std::uint64_t count = 0;  ///< solutions; 0: until the session closes
};

using CommandOptions = std::variant<DoctorOptions,
                                    ModelsOptions,
                                    LoadOptions,
                                    GraspOptions,
                                    SessionsOptions,
                                    WatchOptions,
                                    TransferOptions,
                                    SuggestOptions,
                                    CloseOptions,
                                    UnloadOptions>;

int run(const DoctorOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const ModelsOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const LoadOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const GraspOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const SessionsOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const WatchOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const TransferOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const SuggestOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const CloseOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const UnloadOptions& options, const CommonOptions& common, Interruption& interruption);

}  // namespace handgraft::client
