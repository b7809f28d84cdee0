#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/study/study_axis.h"
#include "client/cli/study/study_files.h"
#include "client/link/model_files.h"
#include "core/base/network.h"
#include "idl/models.h"
#include "idl/motions.h"
#include "idl/sessions.h"

/// The commands of `handgraft`, one file each. A command prints to standard output, notices to
/// standard error, and returns the exit code; errors leave as exceptions for main.cpp.
namespace handgraft::client {

class Interruption;

/// Options of every command.
struct CommonOptions {
  Network network;
  bool json = false;  ///< exactly one JSON document on standard output (`watch`: one a line)
  /// A command that is not done by then ends; nothing: `longestOf` it.
  std::optional<double> timeout_s;
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
  std::string units;   ///< of meshes and maps; empty: metres unless the size says otherwise
  HandReading hand_reading;        ///< hands alone
  ContactReading contact_reading;  ///< contact maps alone
};

/// X_WO: x y z in m, qw qx qy qz.
using Place = std::array<double, 7>;

struct GraspOptions {
  std::string hand;  ///< a model's name, or a path; likewise the next two
  std::string object;
  std::string contacts;
  std::string units;  ///< of the object and of the contacts, where those are paths
  HandReading hand_reading;
  ContactReading contact_reading;
  std::optional<Place> place;
  std::optional<std::array<double, 3>> weights;  ///< distance (1/m^2), normal, prior
  std::string solver;
  std::uint32_t starts = 0;
  std::uint32_t seed = 0;
  std::uint32_t max_evaluations = 0;
  bool paper = false;
  v1::NormalForm normal_form = v1::NORMAL_COSINE;
  bool touch_only = false;
  std::uint32_t choose = 0;          ///< rank of the result to take, from 1; 0: the best
  std::string log_map;               ///< empty: the server's default
  std::uint32_t interior_rings = 0;  ///< of correspondences besides the boundary's
  std::filesystem::path out;         ///< empty: not written; likewise the next two
  std::filesystem::path png;
  std::filesystem::path problem;
  bool keep = false;
};

struct InspectOptions {
  std::string hand;  ///< a model's name, or a path
  HandReading reading;
  std::string units;
  std::filesystem::path png;  ///< empty: not written; likewise the next
  std::filesystem::path sites;
};

struct VaryOptions {
  std::string hand;  ///< a model's name, or a path
  HandReading reading;
  std::string units;
  std::vector<v1::HandChange> changes;
  std::string name;            ///< of the variant
  std::filesystem::path urdf;  ///< empty: not written
};

/// A study of a set of grasps over properties of a hand.
struct SweepOptions {
  std::string hand;  ///< a model's name, or a path
  HandReading hand_reading;
  StudyFolders folders;
  ContactReading contact_reading;  ///< of contact maps
  std::string units;               ///< of objects and contact maps
  std::vector<StudyAxis> axes;
  std::optional<std::array<double, 3>> weights;  ///< distance (1/m^2), normal, prior
  std::string solver;
  std::uint32_t starts = 0;
  std::uint32_t seed = 0;
  std::string log_map;
  std::filesystem::path out;  ///< CSV; empty: not written; likewise the next
  std::filesystem::path png;
};

struct SkinOptions {
  std::string hand;  ///< a model's name, or a path
  HandReading reading;
  std::string units;
  std::filesystem::path out;
  std::filesystem::path png;  ///< empty: not written
};

struct ImportOptions {
  std::filesystem::path map;  ///< or a contact set
  std::string object;         ///< a model's name, or a path
  ContactReading reading;
  std::string units;
  std::string name;           ///< empty: from the map's path
  std::filesystem::path out;  ///< empty: not written; likewise the next
  std::filesystem::path png;
};

struct PoseContactsOptions {
  std::string hand;  ///< a model's name, or a path
  HandReading reading;
  std::string pose;    ///< a file, or one of the hand's named poses
  std::string object;  ///< a model's name, or a path
  std::string units;   ///< of the object
  std::optional<Place> place;
  double reach_mm = 0.0;  ///< 0: the server's default
  v1::ContactOptions contacts;
  std::string name;           ///< empty: after the object and the hand
  std::filesystem::path out;  ///< empty: not written; likewise the next
  std::filesystem::path png;
};

struct MotionShowOptions {
  std::string motion;  ///< a model's name, or a path; likewise the next
  std::string object;  ///< empty: the one that the motion names
  std::string units;   ///< of the object
};

/// A motion of a recording, of what a hand did, or of two grasps and the object's path.
struct MotionImportOptions {
  std::filesystem::path recording;    ///< empty: two grasps
  std::filesystem::path object_path;  ///< of a recording; empty: the object stands still
  std::string hand;  ///< that did what is recorded: a model's name, or a path; empty: not so
  HandReading hand_reading;
  std::optional<double> reach_m;  ///< of that hand: distance at which contact ends
  std::optional<double> every_s;  ///< likewise: how often contacts are cut
  std::string first;              ///< contacts: a model's name, or a path; likewise the next
  std::string last;
  std::filesystem::path path;  ///< of the object
  std::optional<double> rate_hz;
  std::optional<double> slide_begin;  ///< share of the time; likewise the next three
  std::optional<double> slide_end;
  std::optional<double> vanish;
  std::optional<double> appear;
  std::string object;  ///< a model's name, or a path; empty: the one that is named there
  std::string units;   ///< of the object
  std::string name;
  bool is_named = false;      ///< by the user
  std::filesystem::path out;  ///< empty: not written
};

/// A file of a hand's way, and what it is to be.
struct MotionFile {
  std::filesystem::path path;
  std::string format;  ///< as ExportFormat names it
};

struct MotionSolveOptions {
  std::string hand;    ///< a model's name, or a path; likewise the next two
  std::string object;  ///< empty: the one that the motion names
  std::string motion;
  HandReading hand_reading;
  std::string units;  ///< of the object
  bool causal = false;
  double smoothness = 0.0;  ///< 0: the server's default; likewise the next
  double fade_s = 0.0;
  double acceleration_limit = 0.0;  ///< 0: none
  std::uint32_t starts = 0;
  std::uint32_t seed = 0;
  std::vector<MotionFile> out;
  std::filesystem::path png;     ///< empty: not written; likewise the next
  std::filesystem::path frames;  ///< a table of them
  bool keep = false;
};

/// A recorded demonstrator, played to a session.
struct MotionClockOptions {
  std::uint64_t session_id = 0;
  v1::ClockAction action = v1::CLOCK_PLAY;
  double value = 0.0;
};

struct MotionFollowOptions {
  std::uint64_t session_id = 0;
  std::filesystem::path demonstration;
  double speed = 1.0;
  bool loops = false;
  std::vector<MotionFile> out;  ///< what the hand did
};

/// The way of a session's hand as timed samples.
struct MotionPlayOptions {
  std::uint64_t session_id = 0;
  std::string topic;  ///< empty: the session's own
  double rate_hz = 120.0;
  double speed = 1.0;
  double from_s = 0.0;
  double lead_in_s = 0.5;  ///< at the first pose, so that the hand goes there
  bool loops = false;
  bool paused = false;  ///< until it is told to play
  bool stays = false;   ///< at the end, until it is told to quit
};

struct EditOptions {
  std::uint64_t session_id = 0;  ///< 0: a new one, of `grasp`
  GraspOptions grasp;
  std::filesystem::path script;  ///< empty: standard input
  std::optional<double> at_s;    ///< of the session's motion, where the edits begin
  double falloff_s = 0.0;
};

struct ExportOptions {
  std::uint64_t session_id = 0;
  std::string format;
  std::filesystem::path out;
  bool is_of_motion = false;  ///< asked for by `motion export`
  bool is_live = false;       ///< of what the hand did after a demonstrator
};

struct SaveOptions {
  std::uint64_t session_id = 0;
  std::filesystem::path path;
};

struct OpenFileOptions {
  std::filesystem::path path;
};

struct ShareOptions {
  std::uint64_t session_id = 0;
  std::vector<std::string> with;  ///< identities, or "everyone" or "nobody" alone
  std::string owner;              ///< an identity to hand it to; empty: as it is
};

struct ReplayOptions {
  std::filesystem::path path;
  std::filesystem::path out;  ///< empty: not written
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

/// One bridge, or all of them, and what it is asked to do.
struct BridgeOptions {
  enum class Action { kStatus, kArm, kDisarm, kEstop, kReset, kHome };

  Action action = Action::kStatus;
  std::optional<std::uint32_t> bridge_id;  ///< nothing: the only one; status and estop: all
};

struct BridgeRecordOptions {
  std::optional<std::uint32_t> bridge_id;  ///< nothing: the only one
  double seconds = 10;                     ///< 0: until interrupted
  std::filesystem::path out;
  std::filesystem::path png;  ///< empty: not written
};

struct BridgePlotOptions {
  std::filesystem::path run;
  std::filesystem::path out;
};

/// What `handgraft-bridge` itself does, alone with a device: scan, make-config, jog, check.
struct BringUpOptions {
  std::vector<std::string> arguments;
};

/// A page in the browser.
struct ViewOptions {
  std::uint64_t session_id = 0;  ///< 0: of `file`, or a new one of `grasp`, or all there are
  std::filesystem::path file;    ///< handgraft-session/1; empty: none
  GraspOptions grasp;            ///< without a hand: none
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: any that is free
  bool read_only = false;
  bool open_browser = true;
};

/// The identities of a secured domain.
struct KeysOptions {
  enum class Action { kInit, kAdd, kShow, kRevoke };

  Action action = Action::kShow;
  std::filesystem::path folder;  ///< the authority's; empty: the usual one
  std::string name;
  std::string role;
  int days = 365;
};

struct WatchOptions {
  std::uint64_t session_id = 0;
  std::uint64_t count = 0;  ///< solutions; 0: until the session closes
};

using CommandOptions = std::variant<DoctorOptions,
                                    ModelsOptions,
                                    LoadOptions,
                                    GraspOptions,
                                    InspectOptions,
                                    VaryOptions,
                                    SweepOptions,
                                    SkinOptions,
                                    ImportOptions,
                                    PoseContactsOptions,
                                    MotionShowOptions,
                                    MotionImportOptions,
                                    MotionSolveOptions,
                                    MotionPlayOptions,
                                    MotionClockOptions,
                                    MotionFollowOptions,
                                    EditOptions,
                                    ExportOptions,
                                    SaveOptions,
                                    OpenFileOptions,
                                    ReplayOptions,
                                    ShareOptions,
                                    SessionsOptions,
                                    BridgeOptions,
                                    BridgeRecordOptions,
                                    BridgePlotOptions,
                                    BringUpOptions,
                                    ViewOptions,
                                    KeysOptions,
                                    WatchOptions,
                                    TransferOptions,
                                    SuggestOptions,
                                    CloseOptions,
                                    UnloadOptions>;

int run(const DoctorOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const ModelsOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const LoadOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const GraspOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const InspectOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const VaryOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const SweepOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const SkinOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const ImportOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const PoseContactsOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const MotionShowOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const MotionImportOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const MotionClockOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const MotionFollowOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const MotionPlayOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const MotionSolveOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const EditOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const ExportOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const SaveOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const OpenFileOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const ShareOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const ReplayOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const SessionsOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const BridgeOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const BridgeRecordOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const BridgePlotOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const BringUpOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const ViewOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const KeysOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const WatchOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const TransferOptions& options,
        const CommonOptions& common,
        Interruption& interruption);
int run(const SuggestOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const CloseOptions& options, const CommonOptions& common, Interruption& interruption);
int run(const UnloadOptions& options, const CommonOptions& common, Interruption& interruption);

}  // namespace handgraft::client
