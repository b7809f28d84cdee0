#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/link/model_files.h"

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11's
class App;
class Option;
}  // namespace CLI

/// Options that several commands share: how a model's files are to be read. CLI11 writes into
/// them until it has parsed, so they must stay where they are.
namespace handgraft::client {

/// `--mirror --srdf --rest --surfaces --alpha --offset --edge --package`.
class HandFlags {
 public:
  void addTo(CLI::App& command);

  /// What they say. Errors: InvalidInput for lengths out of range and packages that are none.
  [[nodiscard]] HandReading reading() const;

  /// Errors: InvalidInput naming the first of them that was given if `hand` is no path: what
  /// the server has already has been read.
  void requirePath(const std::string& hand, const char* option) const;
  /// Likewise if any was given: they are for `whom` alone.
  void requireUnused(const char* whom) const;

 private:
  std::vector<CLI::Option*> options_;
  bool mirrored_ = false;
  std::string srdf_;
  std::string rest_pose_;
  std::string surfaces_;
  std::optional<double> alpha_mm_;
  std::optional<double> offset_mm_;
  std::optional<double> edge_mm_;
  std::vector<std::string> packages_;
};

/// `--value --label --colors --picture --joints --joints-hand` say what a contact map shows,
/// `--threshold --otsu --low-share --smooth --min-area --points` how patches are found in it.
class ContactFlags {
 public:
  /// `hand_option` names the hand of `--joints`, where `--hand` is not the model's.
  void addSourceTo(CLI::App& command, const std::string& hand_option = "--joints-hand");
  void addSegmentationTo(CLI::App& command);

  /// What they say. Errors: InvalidInput for what is out of range or contradicts itself.
  [[nodiscard]] ContactReading reading() const;

  /// As those of HandFlags.
  void requirePath(const std::string& contacts, const char* option) const;
  void requireUnused(const char* whom) const;

 private:
  std::vector<CLI::Option*> options_;
  std::string value_property_;
  std::string label_property_;
  std::string color_scale_;
  std::string picture_;
  std::string joints_;
  std::string joints_hand_;
  std::optional<double> threshold_;
  bool otsu_ = false;
  std::optional<double> low_share_;
  std::optional<double> outline_share_;
  std::uint32_t smoothing_steps_ = 0;
  std::optional<double> minimum_area_mm2_;
  std::uint32_t interpolation_count_ = 0;
};

/// `--units`, one of kLengthUnits; `whose` they are stands in the help.
void addUnits(CLI::App& command, std::string& units, const std::string& whose);

}  // namespace handgraft::client
