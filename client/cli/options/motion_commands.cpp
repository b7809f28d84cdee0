#include <cmath>
#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/model_flags.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

/// What a file is called, and what it then is: as ExportFormat names them.
struct MotionEnding {
  const char* ending;
  const char* format;
};

constexpr MotionEnding kEndings[] = {{".json", "json"}, {".csv", "csv"},
                                     {".glb", "glb"},   {".npz", "npz"},
                                     {".xml", "mjcf"},  {".yaml", "ros_trajectory"}};

/// `more` are endings that the caller knows beside.
MotionFile motionFileFrom(const std::string& path, const char* more = "") {
  std::string endings;
  for (const MotionEnding& one : kEndings) {
    if (std::filesystem::path(path).extension() == one.ending) return {path, one.format};
    endings += fmt::format("{}{}", endings.empty() ? "" : ", ", one.ending);
  }
  rejectInput("--out {}: its ending says what it is to be: one of {}{}", quoted(path), endings,
              more);
}

void requireObject(const std::string& object, const std::string& units) {
  if (!object.empty()) requireModel(object, "--object");
  if (!units.empty() && !isPath(object))
    rejectInput("--units {}: they are for an object's file", units);
}

double atLeast0(const std::optional<double>& value, const char* option, double most) {
  if (!value) return 0.0;
  if (!(*value > 0.0 && *value <= most))
    rejectInput("{} {}: it must be above 0 and at most {}", option, *value, most);
  return *value;
}

void addShow(CLI::App& motion, CommandOptions& chosen) {
  const auto parsed = std::make_shared<MotionShowOptions>();
  CLI::App* command =
      motion.add_subcommand("show", "Tell how long a motion is and when which patch is there");
  command->add_option("motion", parsed->motion, "Model name, or path of a motion")->required();
  command->add_option("--object", parsed->object,
                      "Model name, or path of a mesh; default: the one that the motion names");
  addUnits(*command, parsed->units, "the object");
  command->fallthrough();
  command->callback([parsed, &chosen] {
    requireModel(parsed->motion, "motion");
    requireObject(parsed->object, parsed->units);
    chosen = *parsed;
  });
}

// What the ways to a motion have in common.
struct ParsedMotion {
  MotionImportOptions options;
  std::string recording;
  std::string object_path;
  HandFlags hand_flags;
  std::optional<double> reach_mm;
  std::optional<double> every_ms;
  std::string path;
  std::string out;
  std::vector<double> slide;

  void addTo(CLI::App& command) {
    command.add_option("--object", options.object,
                       "Model name, or path of a mesh; default: the one that is named there");
    command.add_option("--name", options.name, "What to call the motion");
    command.add_option("--out", out, "Write it as handgraft-motion/1")->check(objectionToFile);
    addUnits(command, options.units, "the object");
  }

  /// `otherwise`: what to call it where nobody says.
  MotionImportOptions checked(const std::string& otherwise) {
    requireObject(options.object, options.units);
    options.is_named = !options.name.empty();
    if (options.is_named) {
      checkModelName(options.name, "--name");
    } else {
      options.name = nameFromPath(otherwise);
    }
    options.recording = recording;
    options.object_path = object_path;
    options.path = path;
    options.out = out;
    return options;
  }
};

/// A recording of a hand of the server, if one is named.
void checkHand(ParsedMotion& parsed) {
  MotionImportOptions& given = parsed.options;
  if (given.hand.empty()) {
    if (parsed.reach_mm || parsed.every_ms)
      rejectInput("{} is of what a hand did: it needs --hand",
                  parsed.reach_mm ? "--reach" : "--every");
    parsed.hand_flags.requireUnused("--hand");
    return;
  }
  requireModel(given.hand, "--hand");
  parsed.hand_flags.requirePath(given.hand, "--hand");
  if (!parsed.object_path.empty())
    rejectInput("--object-path and --hand: what a hand did says itself where the object was");
  given.hand_reading = parsed.hand_flags.reading();
  if (parsed.reach_mm) given.reach_m = scaled(parsed.reach_mm, "--reach", 0.1, 100.0, 1e-3);
  if (parsed.every_ms) given.every_s = scaled(parsed.every_ms, "--every", 1.0, 10'000.0, 1e-3);
}

void addMotionImport(CLI::App& motion, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedMotion>();
  CLI::App* command = motion.add_subcommand(
      "import", "Read a motion, or what a hand did, and write it as a motion");
  command
      ->add_option("recording", parsed->recording,
                   "A motion, contact points a frame, a human hand over time; with --hand what "
                   "that hand did (JSON or CSV, as motion solve --out writes it)")
      ->required();
  command->add_option("--object-path", parsed->object_path,
                      "A .smexp: the splines that the object follows");
  command->add_option("--hand", parsed->options.hand,
                      "The hand that did it, model name or path of a URDF: the areas that it "
                      "touches become the motion's contacts");
  command->add_option("--reach", parsed->reach_mm,
                      "How far from that hand contact ends: 0.1-100 mm, default 10");
  command->add_option("--every", parsed->every_ms,
                      "How often its contacts are cut: 1-10000 ms, default 50");
  parsed->hand_flags.addTo(*command);
  parsed->addTo(*command);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    checkHand(*parsed);
    chosen = parsed->checked(parsed->recording);
  });
}

void requireShare(const std::optional<double>& share, const char* option) {
  if (share && !(*share >= 0.0 && *share <= 1.0))
    rejectInput("{} {}: it is a share of the time, 0 to 1", option, *share);
}

void addJoin(CLI::App& motion, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedMotion>();
  MotionImportOptions& options = parsed->options;
  CLI::App* command = motion.add_subcommand(
      "join", "Make a motion of a first grasp, a last one and the object's path");
  command->add_option("first", options.first, "Contacts: model name, or path of a set")
      ->required();
  command->add_option("last", options.last, "Likewise; may be the same")->required();
  command
      ->add_option("--path", parsed->path,
                   "CSV of the object's poses: time_s,x,y,z,qw,qx,qy,qz")
      ->required();
  command->add_option("--rate", options.rate_hz, "Frames a second; default 60");
  command
      ->add_option("--slide", parsed->slide,
                   "When patches slide, as shares of the time; default 0.25 0.75")
      ->expected(2);
  command->add_option("--vanish", options.vanish,
                      "When patches go that the last grasp lacks; default 0.4");
  command->add_option("--appear", options.appear,
                      "When patches come that the first grasp lacks; default 0.6");
  parsed->addTo(*command);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    MotionImportOptions& given = parsed->options;
    requireModel(given.first, "first");
    requireModel(given.last, "last");
    if (given.rate_hz && !(*given.rate_hz > 0.0 && *given.rate_hz <= 1e5))
      rejectInput("--rate {}: it must be above 0 and at most 100000", *given.rate_hz);
    if (!parsed->slide.empty()) {
      given.slide_begin = parsed->slide[0];
      given.slide_end = parsed->slide[1];
    }
    requireShare(given.slide_begin, "--slide");
    requireShare(given.slide_end, "--slide");
    requireShare(given.vanish, "--vanish");
    requireShare(given.appear, "--appear");
    chosen = parsed->checked(given.first);
  });
}

struct ParsedSolve {
  MotionSolveOptions solve;
  std::optional<double> smoothness;
  std::optional<double> fade_ms;
  std::optional<double> acceleration;
  std::vector<std::string> out;
  std::string png;
  std::string frames;
  HandFlags hand;
};

MotionSolveOptions solveOf(const ParsedSolve& parsed) {
  MotionSolveOptions solve = parsed.solve;
  requireModel(solve.hand, "--hand");
  requireModel(solve.motion, "--motion");
  requireObject(solve.object, solve.units);
  parsed.hand.requirePath(solve.hand, "--hand");
  solve.hand_reading = parsed.hand.reading();
  solve.smoothness = atLeast0(parsed.smoothness, "--smoothness", 1e12);
  solve.fade_s = 1e-3 * atLeast0(parsed.fade_ms, "--fade", 6e4);
  solve.acceleration_limit = atLeast0(parsed.acceleration, "--acceleration", 1e6);
  if (solve.starts > 10'000)
    rejectInput("--starts {}: at most 10000 are permitted", solve.starts);
  for (const std::string& path : parsed.out)
    solve.out.push_back(motionFileFrom(path));
  solve.png = parsed.png;
  solve.frames = parsed.frames;
  return solve;
}

void addSolve(CLI::App& motion, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedSolve>();
  MotionSolveOptions& solve = parsed->solve;
  CLI::App* command = motion.add_subcommand("solve", "Have a hand follow a motion");
  command->add_option("--hand", solve.hand, "Model name, or path of a URDF")->required();
  command->add_option("--motion", solve.motion, "Model name, or path of a motion")->required();
  command->add_option("--object", solve.object,
                      "Model name, or path of a mesh; default: the one that the motion names");
  command->add_flag("--causal", solve.causal,
                    "Each frame from those before it alone; unlike `motion follow`, which also "
                    "searches anew where the hand is lost");
  command->add_option("--smoothness", parsed->smoothness,
                      "Weight of second differences; default 5e5, --causal 1e4");
  command->add_option("--fade", parsed->fade_ms,
                      "In how many ms patches come and go; default 60");
  command->add_option("--acceleration", parsed->acceleration,
                      "Limit of every joint (rad/s^2 or m/s^2); default: none");
  command->add_option("--starts", solve.starts, "Of single frames; 0: the server's default")
      ->check(objectionToSmallCount);
  command->add_option("--seed", solve.seed, "Seed of the starts after the first")
      ->check(objectionToSmallCount);
  command
      ->add_option(
          "--out", parsed->out,
          "Write the hand's way; the ending says how: .json .csv .glb .npz .xml (MJCF) "
          ".yaml (ROS 2); may be given again")
      ->check(objectionToFile)
      ->allow_extra_args(false);
  command->add_option("--frames", parsed->frames, "Write fit and speeds of each frame as CSV")
      ->check(objectionToFile);
  command->add_option("--png", parsed->png, "Draw a strip of frames and a plot over time")
      ->check(objectionToPng);
  command->add_flag("--keep", solve.keep, "Leave the session open");
  addUnits(*command, solve.units, "the object");
  parsed->hand.addTo(*command);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    chosen = solveOf(*parsed);
  });
}

void addPlay(CLI::App& motion, CommandOptions& chosen) {
  const auto parsed = std::make_shared<MotionPlayOptions>();
  CLI::App* command = motion.add_subcommand(
      "play",
      "Play what a session's hand does as timed samples, for a bridge or ROS 2; play, pause, "
      "seek S, speed X, loop on|off and quit are read from standard input");
  command
      ->add_option("session", parsed->session_id,
                   "Its id, or the first digits of it; its motion has been solved")
      ->required()
      ->check(objectionToCount);
  command->add_option("--topic", parsed->topic,
                      "Where to; default rt/handgraft/<session>/joint_trajectory");
  command->add_option("--rate", parsed->rate_hz, "Samples a second; default 120");
  command->add_option("--speed", parsed->speed, "Times real time; default 1");
  command->add_option("--from", parsed->from_s, "Where to begin (s)");
  command->add_option("--lead-in", parsed->lead_in_s,
                      "How long the hand is given to get there (s); default 0.5");
  command->add_flag("--loop", parsed->loops, "Again and again");
  command->add_flag("--paused", parsed->paused, "Stand at the beginning until `play`");
  command->add_flag("--stay", parsed->stays, "Wait for more at the end, until `quit`");
  command->fallthrough();
  command->callback([parsed, &chosen] {
    if (!(parsed->rate_hz >= 1.0 && parsed->rate_hz <= 1000.0))
      rejectInput("--rate {}: it must be 1 to 1000 samples a second", parsed->rate_hz);
    if (!(parsed->lead_in_s >= 0.0 && parsed->lead_in_s <= 3600.0))
      rejectInput("--lead-in {}: it must be 0 to 3600 s", parsed->lead_in_s);
    chosen = *parsed;
  });
}

double numberAfter(const std::string& verb, const std::string& text) {
  std::size_t read = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &read);
  } catch (const std::exception&) {
    read = 0;
  }
  if (read == 0 || read != text.size())
    rejectInput("{} {}: a number must follow", verb, handgraft::quoted(text));
  return value;
}

/// `verb` and what follows it: play, pause, seek S, speed X, loop on|off.
void setClockAction(const std::string& verb,
                    const std::string& value,
                    MotionClockOptions& options) {
  if (verb == "play" || verb == "pause") {
    options.action = verb == "play" ? v1::CLOCK_PLAY : v1::CLOCK_PAUSE;
    if (!value.empty()) rejectInput("{}: nothing follows it", verb);
  } else if (verb == "seek" || verb == "speed") {
    options.action = verb == "seek" ? v1::CLOCK_SEEK : v1::CLOCK_SPEED;
    options.value = numberAfter(verb, value);
  } else if (verb == "loop") {
    if (value != "on" && value != "off")
      rejectInput("loop {}: on or off", handgraft::quoted(value));
    options.action = v1::CLOCK_LOOP;
    options.value = value == "on" ? 1.0 : 0.0;
  } else {
    rejectInput("{}: there are play, pause, seek S, speed X, loop on|off",
                handgraft::quoted(verb));
  }
}

void addClock(CLI::App& motion, CommandOptions& chosen) {
  struct Parsed {
    MotionClockOptions options;
    std::string verb;
    std::string value;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command = motion.add_subcommand(
      "clock", "Set the clock that all who watch a session's motion share");
  command
      ->add_option("session", parsed->options.session_id,
                   "Its id, or the first digits of it, at least four")
      ->required()
      ->check(objectionToCount);
  command->add_option("action", parsed->verb, "play, pause, seek S, speed X or loop on|off")
      ->required();
  command->add_option("value", parsed->value, "Of seek (s), speed (times real time) or loop");
  command->fallthrough();
  command->callback([parsed, &chosen] {
    setClockAction(parsed->verb, parsed->value, parsed->options);
    chosen = parsed->options;
  });
}

void addFollow(CLI::App& motion, CommandOptions& chosen) {
  const auto parsed = std::make_shared<MotionFollowOptions>();
  const auto file = std::make_shared<std::string>();
  const auto out = std::make_shared<std::vector<std::string>>();
  CLI::App* command = motion.add_subcommand(
      "follow",
      "Play a recorded human hand to a session, whose hand follows it live, frame by frame");
  command
      ->add_option("session", parsed->session_id,
                   "Its id, or the first digits of it, at least four")
      ->required()
      ->check(objectionToCount);
  command
      ->add_option("demonstration", *file, "handgraft-demonstration/1 (JSON), or NumPy's .npz")
      ->required();
  command->add_option("--speed", parsed->speed, "Times real time; default 1");
  command->add_flag("--loop", parsed->loops, "Again and again");
  command
      ->add_option("--out", *out,
                   "Write what the hand did; the ending says how: .json .csv .glb .npz .xml "
                   "(MJCF) .yaml (ROS 2); may be given again")
      ->check(objectionToFile)
      ->allow_extra_args(false);
  command->fallthrough();
  command->callback([parsed, file, out, &chosen] {
    if (!(parsed->speed >= 0.01 && parsed->speed <= 100.0))
      rejectInput("--speed {}: it must be 0.01 to 100 times real time", parsed->speed);
    parsed->demonstration = *file;
    for (const std::string& path : *out)
      parsed->out.push_back(motionFileFrom(path));
    chosen = *parsed;
  });
}

void addMotionExport(CLI::App& motion, CommandOptions& chosen) {
  struct Parsed {
    std::uint64_t session_id = 0;
    std::string out;
    bool is_live = false;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command =
      motion.add_subcommand("export", "Write what a session's hand does over time as a file");
  command
      ->add_option("session", parsed->session_id,
                   "Its id, or the first digits of it, at least four")
      ->required()
      ->check(objectionToCount);
  command
      ->add_option(
          "--out", parsed->out,
          "The ending says how: .json .csv .glb .npz .xml (MJCF) .yaml (ROS 2) .html (the "
          "page)")
      ->required()
      ->check(objectionToFile);
  command->add_flag("--live", parsed->is_live,
                    "What the hand did last after a demonstrator (motion follow, Python)");
  command->fallthrough();
  command->callback([parsed, &chosen] {
    const bool is_page = std::filesystem::path(parsed->out).extension() == ".html";
    if (is_page && parsed->is_live)
      rejectInput("--live: a page shows a motion as it was solved");
    const MotionFile file =
        is_page ? MotionFile{parsed->out, "html"} : motionFileFrom(parsed->out, ", .html");
    chosen = ExportOptions{parsed->session_id, file.format, file.path, true, parsed->is_live};
  });
}

}  // namespace

void addMotionCommands(CLI::App& app, CommandOptions& chosen) {
  CLI::App* motion =
      app.add_subcommand("motion", "Contacts that move, and a hand that follows them");
  motion->require_subcommand(1);
  addMotionImport(*motion, chosen);
  addJoin(*motion, chosen);
  addShow(*motion, chosen);
  addSolve(*motion, chosen);
  addPlay(*motion, chosen);
  addClock(*motion, chosen);
  addFollow(*motion, chosen);
  addMotionExport(*motion, chosen);
}

}  // namespace handgraft::client
