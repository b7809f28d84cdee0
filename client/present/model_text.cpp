#include "client/present/model_text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "client/present/joint_unit.h"
#include "client/present/motion_output.h"
#include "client/present/text_output.h"

namespace handgraft::client::text {

namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string number(double value) {
  return std::isinf(value) ? (value < 0.0 ? "-inf" : "inf") : fmt::format("{:.1f}", value);
}

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string typeOf(const v1::JointInfo& joint) {
  if (joint.kind() == v1::JOINT_PRISMATIC) return "prismatic";
  return std::isinf(joint.lower()) && std::isinf(joint.upper()) ? "continuous" : "revolute";
}

/// All numbers of a joint, as the contract lists them; 0 of what a model need not say is "-".
std::vector<const idl::Field*> jointNumbers() {
  std::vector<const idl::Field*> numbers;
  for (const idl::Field& field : idl::typeOf<v1::JointInfo>().fields)
    if (field.type->kind == idl::Kind::kDouble) numbers.push_back(&field);
  return numbers;
}

std::string joints(const v1::HandDescription& hand) {
  const std::vector<const idl::Field*> numbers = jointNumbers();
  std::vector<std::string> heading = {"joint", "type", "parent > child"};
  for (const idl::Field* field : numbers) {
    std::string words = field->name;
    std::replace(words.begin(), words.end(), '_', ' ');
    heading.push_back(std::move(words));
  }
  heading.insert(heading.end(), {"rest", ""});
  Rows rows = {heading};
  for (std::size_t i = 0; i < hand.joints().size(); ++i) {
    v1::JointInfo joint = hand.joints()[i];
    std::vector<std::string> row = {
        plain(joint.name()), typeOf(joint),
        plain(joint.parent_link()) + " > " + plain(joint.child_link())};
    const JointUnit unit = unitOf(joint.kind());
    for (const idl::Field* field : numbers) {
      const double value = unit.scale * *static_cast<const double*>(field->in(&joint));
      row.push_back(field->infinite ? number(value)
                    : value > 0.0   ? fmt::format("{:.4g}", value)
                                    : "-");
    }
    row.push_back(
        i < hand.rest_positions().size() ? number(unit.scale * hand.rest_positions()[i]) : "");
    row.emplace_back(unit.name);
    rows.push_back(std::move(row));
  }
  return table(rows, "lll" + std::string(numbers.size() + 1, 'r') + "l");
}

// "ip = 0.5 * mcp + 0.1"
std::string formula(const v1::MimicInfo& mimic) {
  std::string text = fmt::format("{} = {:.4g} * {}", plain(mimic.joint()), mimic.multiplier(),
                                 plain(mimic.source()));
  if (mimic.offset() != 0.0) {
    text +=
        fmt::format(" {} {:.4g}", mimic.offset() < 0.0 ? "-" : "+", std::abs(mimic.offset()));
  }
  return text;
}

// Three numbers as wide as `width`; none of them is -0.
std::string three(const std::array<double, 3>& v, double scale, int width, int digits) {
  const double step = std::pow(10.0, -digits);
  std::string text;
  for (const double x : v) {
    const double rounded = std::round(scale * x / step) * step;
    text += fmt::format("{}{:{}.{}f}", text.empty() ? "" : " ", rounded + 0.0, width, digits);
  }
  return text;
}

std::string millimetres(const std::array<double, 3>& p_m) {
  return three(p_m, 1e3, 7, 1);
}

std::string unit(const std::array<double, 3>& n) {
  return three(n, 1.0, 5, 2);
}

std::string sites(const v1::HandDescription& hand) {
  Rows rows = {{"site", "link", "point mm", "normal", "direction"}};
  for (const v1::SiteInfo& site : hand.sites()) {
    rows.push_back({plain(site.name()), plain(site.link()), millimetres(site.p_L_m()),
                    unit(site.n_L()), unit(site.direction_L())});
  }
  return table(rows, "llrrr");
}

/// What gave a digit its name. A site counts before the names of links and joints.
std::string namedBy(const v1::DigitInfo& digit, const v1::HandDescription& hand) {
  const bool has_site =
      std::any_of(hand.sites().begin(), hand.sites().end(), [&](const v1::SiteInfo& site) {
        return site.name() == digit.name();
      });
  if (has_site && !hand.sites_found()) return "its site";
  return digit.named_by_file() ? "names in its file" : "its shape";
}

std::string digits(const v1::HandDescription& hand) {
  Rows rows = {{"digit", "named by", "segments, mm"}};
  for (const v1::DigitInfo& digit : hand.digits()) {
    std::string segments;
    for (const v1::SegmentInfo& segment : digit.segments()) {
      segments +=
          fmt::format("{}{} {:.0f} ({})", segments.empty() ? "" : ", ", plain(segment.name()),
                      1e3 * segment.length_m(), plain(segment.link()));
    }
    rows.push_back({plain(digit.name()), namedBy(digit, hand), segments});
  }
  return table(rows, "lll");
}

// As `plain`, which cuts long texts.
std::string wholeLine(const std::string& text) {
  constexpr std::size_t kPiece = 100;
  std::string line;
  for (std::size_t at = 0; at < text.size(); at += kPiece)
    line += plain(text.substr(at, kPiece));
  return line;
}

// How long an outline is, and how much it covers seen along its mean normal.
struct Outline {
  double length_m = 0.0;
  double flat_area_m2 = 0.0;
};

Outline measured(const std::vector<double>& xyz) {
  Outline outline;
  const std::size_t count = xyz.size() / 3;
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    const Eigen::Vector3d a(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]);
    const Eigen::Vector3d b(xyz[3 * next], xyz[3 * next + 1], xyz[3 * next + 2]);
    outline.length_m += (b - a).norm();
    area += 0.5 * a.cross(b);
  }
  outline.flat_area_m2 = area.norm();
  return outline;
}

}  // namespace

std::string skin(const v1::SkinReport& report) {
  std::string out;
  std::size_t begin = 0;
  while (begin < report.text().size()) {
    const std::size_t end = std::min(report.text().find('\n', begin), report.text().size());
    out += "  " + wholeLine(report.text().substr(begin, end - begin)) + "\n";
    begin = end + 1;
  }
  if (report.valid()) {
    return out + "skin is sound: closed, of one piece, of genus 0, no face crosses another\n";
  }
  std::vector<std::string> flaws;
  if (!report.closed()) flaws.emplace_back("not closed");
  if (report.pieces() != 1) {
    flaws.push_back(
        fmt::format("{} pieces, and no patch goes from one to another", report.pieces()));
  }
  if (report.genus() != 0) flaws.push_back(fmt::format("genus {}", report.genus()));
  if (report.crossing_faces() != 0) {
    flaws.push_back(counted(report.crossing_faces(), "face") + " cross others");
  }
  return out + fmt::format("skin is NOT sound: {}\n", listed(flaws));
}

std::string hand(const v1::HandDescription& hand) {
  std::string out =
      fmt::format("hand {}: {}", plain(hand.name()), counted(hand.joints().size(), "joint"));
  if (!hand.mimics().empty()) {
    out += ", " + counted(hand.mimics().size(), "mimic joint");
  }
  out += fmt::format(", {}, {}\n", counted(hand.links().size(), "link"),
                     counted(hand.sites().size(), "site"));
  if (hand.mirrored()) out += "mirrored: reflected in the root's y-z plane\n";
  out += "\n" + joints(hand);
  if (!hand.mimics().empty()) {
    out += "\n";
    for (const v1::MimicInfo& mimic : hand.mimics())
      out += fmt::format("mimic {}\n", formula(mimic));
  }
  if (!hand.free_root_joints().empty()) {
    out += fmt::format("\nfloating base of the file, cut off: {}\n",
                       listed(hand.free_root_joints()));
  }
  std::vector<std::string> poses;
  for (const v1::NamedPose& pose : hand.poses())
    poses.push_back(pose.name());
  if (!poses.empty()) out += fmt::format("\nnamed poses: {}\n", listed(poses));
  if (!hand.digits().empty()) out += "\n" + digits(hand);
  if (!hand.sites().empty()) {
    out += fmt::format("\nsites {}:\n",
                       hand.sites_found() ? "found on the skin" : "that the hand brought") +
           sites(hand);
  }
  if (!hand.skin_report().empty()) {
    const v1::SkinReport& report = hand.skin_report().front();
    out += fmt::format("\nskin {}:\n", report.from_cache()
                                           ? std::string("from the cache")
                                           : fmt::format("made in {:.1f} s", report.time_s()));
    out += skin(report);
  }
  return out + notes(hand.notes());
}

std::string contacts(const v1::ContactsDescription& set) {
  std::string out =
      fmt::format("contacts {} on {}: {}\n", plain(set.name()), plain(set.object()),
                  set.patches().size() == 1 ? std::string("1 patch")
                                            : fmt::format("{} patches", set.patches().size()));
  if (set.demonstrator() != v1::CHIRALITY_UNKNOWN)
    out += fmt::format("touched by a {} hand\n", nameOf(set.demonstrator()));
  if (!set.contact_map().empty()) {
    out += fmt::format("contact above {:.3g} counts\n", set.contact_map().front().threshold());
  }
  Rows rows = {{"patch", "points", "outline mm", "flat mm2", "weight", "direction"}};
  for (const v1::PatchInfo& patch : set.patches()) {
    const Outline outline = measured(patch.outline_O_m());
    rows.push_back({plain(patch.name()), std::to_string(patch.point_count()),
                    fmt::format("{:.1f}", 1e3 * outline.length_m),
                    fmt::format("{:.0f}", 1e6 * outline.flat_area_m2),
                    fmt::format("{:g}", patch.weight()),
                    patch.direction_O().empty() ? "open" : "given"});
  }
  return out + "\n" + table(rows, "lr") + notes(set.notes());
}

std::string description(const v1::ModelDescription& description) {
  switch (description._d()) {
    case v1::MODEL_HAND:
      return hand(description.hand());
    case v1::MODEL_CONTACTS:
      return contacts(description.contacts());
    case v1::MODEL_MOTION:
      return motion(description.motion());
    case v1::MODEL_OBJECT:
      break;
  }
  const v1::ObjectDescription& object = description.object();
  return fmt::format("object {}: {} vertices, {} triangles\n", plain(object.name()),
                     object.mesh_O().vertices_m().size() / 3,
                     object.mesh_O().triangles().size() / 3) +
         notes(object.notes());
}

}  // namespace handgraft::client::text
