#include "client/editor/show.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "client/present/joint_unit.h"
#include "client/present/text_output.h"
#include "idl/fields.h"

namespace handgraft::client::editor {

namespace {

using json::Json;
using text::plain;
using Rows = std::vector<std::vector<std::string>>;

std::string number(double value) {
  return fmt::format("{:.4g}", value);
}

std::string triple(const std::array<double, 3>& v) {
  return fmt::format("{:.4g} {:.4g} {:.4g}", v[0], v[1], v[2]);
}

std::string place(const v1::Pose& X) {
  const auto& q = X.q_wxyz();
  return fmt::format("{} (quaternion {:.4g} {:.4g} {:.4g} {:.4g})", triple(X.p_m()), q[0], q[1],
                     q[2], q[3]);
}

std::string yes(bool value) {
  return value ? "yes" : "";
}

std::string turned(const std::array<double, 3>& direction, bool open) {
  const bool known = direction[0] != 0.0 || direction[1] != 0.0 || direction[2] != 0.0;
  return (known ? triple(direction) : std::string("-")) + (open ? " (open)" : "");
}

/// The paper's way never does, whatever the session keeps for others.
bool isAvoided(const v1::SolveOptions& solving) {
  return !solving.paper() && solving.penetration() == v1::PENETRATION_AVOIDED;
}

std::string solvingText(const v1::SolveOptions& solving) {
  std::string line = solving.paper() ? "the paper's own" : nameOf(solving.solver());
  line +=
      solving.starts() == 0 ? ", default starts" : fmt::format(", {} starts", solving.starts());
  line += fmt::format(", seed {}", solving.seed());
  if (solving.max_evaluations() > 0)
    line += fmt::format(", at most {} evaluations a start", solving.max_evaluations());
  line += solving.normal_form() == v1::NORMAL_SUM ? ", normals by sum" : ", normals by cosine";
  line += isAvoided(solving) ? ", penetration avoided" : ", penetration reported";
  return line;
}

/// Of the joint that `what` is about; an angle's where the hand has no such joint.
JointUnit unitIn(const std::string& what, const v1::HandDescription& hand) {
  for (const v1::JointInfo& joint : hand.joints()) {
    for (const char* property : {"", " lower", " upper", " soft value"})
      if (what == "joint " + joint.name() + property) return unitOf(joint.kind());
  }
  return unitOf(v1::JOINT_REVOLUTE);
}

/// A joint's value of a message, which has "rad" behind all of them; other texts as they are.
std::string inUnit(const std::string& text, const JointUnit& unit) {
  double value = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_joints = error == std::errc() && text.substr(rest - text.data()) == " rad";
  return is_joints ? fmt::format("{:.6g} {}", unit.scale * value, unit.name) : plain(text);
}

}  // namespace

// === What the session is made of

std::string nameOf(const v1::ClientId& client, const v1::ClientId& own) {
  if (client == own) return "you";
  const bool is_nobody = std::all_of(client.begin(), client.end(), [](std::uint8_t byte) {
    return byte == 0;
  });
  if (is_nobody) return "an earlier client";  // of a server before this one
  return fmt::format("client {:02x}{:02x}{:02x}{:02x}", client[0], client[1], client[2],
                     client[3]);
}

CommandOutput tellSession(const v1::SessionSettings& settings, const v1::ClientId& own) {
  const v1::SessionState& state = settings.state();
  CommandOutput output;
  output.text = text::table(
      {{"session", std::to_string(state.session_id())},
       {"revision", std::to_string(state.revision())},
       {"phase", nameOf(state.phase())},
       {"hand", plain(state.hand())},
       {"object", plain(state.object())},
       state.motion().empty() ? std::vector<std::string>{"contacts", plain(state.contacts())}
                              : std::vector<std::string>{"motion", plain(state.motion())},
       {"last edit", state.last_edit().empty()
                         ? "none"
                         : fmt::format("{} (by {})", plain(state.last_edit()),
                                       nameOf(state.last_client(), own))},
       {"history",
        fmt::format("{} to undo, {} to redo", state.undo_count(), state.redo_count())}},
      "l");
  if (!state.message().empty()) output.text += plain(state.message()) + "\n";
  output.text += text::notes(settings.notes());
  output.data = {{"session", json::jsonOf(state)}, {"notes", settings.notes()}};
  return output;
}

CommandOutput tellPatches(const v1::SessionSettings& settings) {
  CommandOutput output;
  Rows rows = {{"patch", "on", "weight", "site", "root on hand", "direction on hand",
                "root on object", "direction on object"}};
  Json patches = Json::array();
  const auto root = [](const v1::SurfacePoint& point) {
    return fmt::format("face {} {}", point.face(), triple(point.barycentric()));
  };
  for (const v1::PatchState& patch : settings.patches()) {
    rows.push_back(
        {plain(patch.name()), yes(patch.enabled()), number(patch.weight()), plain(patch.site()),
         patch.placed() ? root(patch.root_S()) + (patch.root_is_open() ? " (open)" : "")
                        : "none: " + plain(patch.reason()),
         patch.placed() ? turned(patch.direction_S(), patch.direction_is_open()) : "",
         root(patch.root_O()), turned(patch.direction_O(), false)});
    patches.push_back(json::jsonOf(patch));
  }
  output.text = text::table(rows, "llrl");
  output.data = {{"patches", patches}};
  return output;
}

CommandOutput tellJoints(const v1::SessionSettings& settings) {
  CommandOutput output;
  Rows rows = {{"joint", "value", "prior", "lower", "upper", "", "model", "held"}};
  Json joints = Json::array();
  for (const v1::JointSetting& joint : settings.joints()) {
    const JointUnit unit = unitOf(joint.kind());
    const auto told = [&](double value) {
      return number(unit.scale * value);
    };
    const bool as_model =
        joint.lower() == joint.model_lower() && joint.upper() == joint.model_upper();
    std::string held = joint.locked() ? "locked" : "";
    if (joint.soft()) {
      held +=
          fmt::format("{}soft, weight {:.4g}", held.empty() ? "" : ", ", joint.soft_weight());
    }
    rows.push_back(
        {plain(joint.name()), told(joint.value()), told(joint.prior()), told(joint.lower()),
         told(joint.upper()), unit.name,
         as_model ? "" : told(joint.model_lower()) + " to " + told(joint.model_upper()), held});
    joints.push_back(json::jsonOf(joint));
  }
  output.text = text::table(rows, "lrrrrlll");
  output.data = {{"joints", joints}};
  return output;
}

CommandOutput tellSettings(const v1::SessionSettings& settings) {
  const v1::Weights& weights = settings.weights();
  const v1::PriorShares& shares = settings.prior_shares();
  const v1::TransferOptions& transfer = settings.transfer();
  CommandOutput output;
  output.text = text::table(
      {{"object X_WO", place(settings.X_WO())},
       {"start X_WH", place(settings.X_WH())},
       {"prior X_WH", place(settings.prior_X_WH())},
       {"weights", fmt::format("distance {:.4g}, normal {:.4g}, prior {:.4g}",
                               weights.distance(), weights.normal(), weights.prior())},
       {"prior shares",
        fmt::format("rotation {:.4g}, translation {:.4g}, joints {:.4g}, posture {:.4g}",
                    shares.root_rotation(), shares.root_translation(), shares.joints(),
                    shares.posture())},
       {"solver", solvingText(settings.solving())},
       {"log maps", fmt::format("{}, {} interior rings", nameOf(transfer.method()),
                                transfer.interior_rings())}},
      "l");
  output.data = {{"X_WO", json::jsonOf(settings.X_WO())},
                 {"X_WH", json::jsonOf(settings.X_WH())},
                 {"prior_X_WH", json::jsonOf(settings.prior_X_WH())},
                 {"weights", json::jsonOf(weights)},
                 {"prior_shares", json::jsonOf(shares)},
                 {"solving", json::jsonOf(settings.solving())},
                 {"transfer", json::jsonOf(transfer)}};
  return output;
}

CommandOutput tellHistory(const v1::SessionSettings& settings) {
  CommandOutput output;
  // Oldest first, the present in the middle, as a page is read.
  for (auto edit = settings.undo().rbegin(); edit != settings.undo().rend(); ++edit)
    output.text += fmt::format("  {}\n", plain(*edit));
  output.text += fmt::format("* revision {}\n", settings.state().revision());
  for (const std::string& edit : settings.redo())
    output.text += fmt::format("  {} (undone)\n", plain(edit));
  output.data = {{"undo", settings.undo()}, {"redo", settings.redo()}};
  return output;
}

CommandOutput tellSnapshots(const v1::SessionSettings& settings) {
  CommandOutput output;
  for (const std::string& name : settings.snapshots())
    output.text += plain(name) + "\n";
  if (settings.snapshots().empty()) output.text = "no snapshots\n";
  output.data = {{"snapshots", settings.snapshots()}};
  return output;
}

CommandOutput tellTimes(const v1::SessionSettings& settings) {
  CommandOutput output;
  Rows rows;
  Json times = Json::array();
  for (const v1::TimedState& timed : settings.timed()) {
    rows.push_back(
        {fmt::format("{}", rows.size() + 1), fmt::format("{:.6g} s", timed.time_s()),
         timed.falloff_s() > 0.0 ? fmt::format("+- {:.7g} s", timed.falloff_s()) : "that frame",
         plain(timed.text())});
    times.push_back(json::jsonOf(timed));
  }
  output.text = rows.empty() ? "nothing was edited at a time\n" : text::table(rows, "rrrl");
  output.data = {{"times", times}};
  return output;
}

CommandOutput tellDifferences(const v1::CompareReply& reply,
                              const std::string& a,
                              const std::string& b,
                              const v1::HandDescription& hand) {
  CommandOutput output;
  Rows rows = {{"", plain(a), b.empty() ? "now" : plain(b)}};
  for (const v1::Difference& difference : reply.differences()) {
    const JointUnit unit = unitIn(difference.what(), hand);
    rows.push_back(
        {plain(difference.what()), inUnit(difference.a(), unit), inUnit(difference.b(), unit)});
  }
  output.text = reply.differences().empty() ? "no difference\n" : text::table(rows, "lrr");
  output.data = json::jsonOf(reply);
  return output;
}

}  // namespace handgraft::client::editor
