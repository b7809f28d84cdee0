// Who may include whom. Changing the architecture is one visible line in the table below; the
// folders' order is the order of dependence, and the reasons are in the folders' READMEs.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

struct Layer {
  std::string folder;             ///< longest prefix of the file's path wins
  std::vector<std::string> ours;  ///< folders whose headers it may include, besides its own
  std::vector<std::string> libraries;  ///< names from library_includes
};

const std::vector<std::string> core_layers = {
    "core/base",     "core/formats",     "core/geometry",
    "core/cloud",    "core/hand",        "core/contact",
    "core/transfer", "core/optimize",    "core/manipulation",
    "core/quality",  "core/placement",   "core/demonstration",
    "core/session",  "core/retargeting", "core/verdict",
    "core/sweep",    "core/io"};

const std::vector<Layer> all_layers = {
    {"core/base", {}, {"eigen", "fmt"}},
    {"core/formats", {"core/base"}, {"eigen", "fmt"}},
    {"core/geometry", {"core/base"}, {"eigen", "fmt"}},
    {"core/cloud", {"core/base", "core/geometry"}, {"eigen", "fmt"}},
    {"core/hand", {"core/base", "core/geometry"}, {"eigen", "fmt"}},
    {"core/contact", {"core/base", "core/geometry", "core/hand"}, {"eigen", "fmt"}},
    {"core/transfer",
     {"core/base", "core/geometry", "core/hand", "core/contact"},
     {"eigen", "fmt"}},
    {"core/optimize",
     {"core/base", "core/geometry", "core/hand", "core/transfer"},
     {"eigen", "fmt"}},
    {"core/quality",
     {"core/base", "core/geometry", "core/hand", "core/transfer"},
     {"eigen", "fmt"}},
    {"core/manipulation",
     {"core/base", "core/geometry", "core/hand", "core/contact", "core/transfer",
      "core/optimize"},
     {"eigen", "fmt"}},
    {"core/placement",
     {"core/base", "core/geometry", "core/hand", "core/contact", "core/transfer",
      "core/optimize", "core/quality"},
     {"eigen", "fmt"}},
    {"core/demonstration",
     {"core/base", "core/geometry", "core/hand", "core/contact", "core/manipulation",
      "core/placement"},
     {"eigen", "fmt"}},
    {"core/session",
     {"core/base", "core/geometry", "core/hand", "core/contact", "core/transfer",
      "core/optimize", "core/manipulation", "core/placement"},
     {"eigen", "fmt"}},
    {"core/retargeting",
     {"core/base", "core/geometry", "core/hand", "core/contact", "core/transfer",
      "core/optimize", "core/manipulation", "core/quality", "core/placement", "core/session"},
     {"eigen", "fmt"}},
    {"core/verdict",
     {"core/base", "core/geometry", "core/optimize", "core/placement", "core/quality",
      "core/session"},
     {"eigen", "fmt"}},
    {"core/sweep",
     {"core/base", "core/geometry", "core/hand", "core/contact", "core/transfer",
      "core/optimize", "core/manipulation", "core/quality", "core/placement", "core/session",
      "core/retargeting"},
     {"eigen", "fmt"}},
    {"core/io", core_layers, {"eigen", "fmt"}},
    {"core/include", core_layers, {}},  // handgraft/core.h
    {"core/examples", {}, {"handgraft"}},
    {"idl", {"core/base"}, {"fmt"}},
    {"idl/security", {"core/base", "idl"}, {"fmt"}},
    {"idl/datagrams", {}, {}},
    {"idl/cyclone", {"core/base", "idl", "idl/datagrams", "idl/security"}, {"fmt"}},
    {"server",
     {"idl/security", "server/log"},
     {"eigen", "fmt"}},  // and all of core and idl, see permits()
    {"server/reading", core_layers, {"eigen", "fmt"}},
    {"server/transport",
     {"core/base", "idl", "idl/datagrams", "idl/security", "server/log"},
     {"fmt", "fastdds"}},
    {"server/log", {}, {"fmt", "spdlog"}},
    {"client/link",
     {"core/base", "core/formats", "idl", "idl/cyclone", "idl/security"},
     {"eigen", "fmt"}},
    {"client/include", {"core/base", "client/link", "idl"}, {}},  // handgraft/client.h
    {"client/examples", {}, {"handgraft"}},
    {"client/python", {"core/base", "client/gateway", "client/link", "idl"}, {"eigen", "fmt"}},
    {"client/present", {"core/base", "client/link", "idl", "idl/cyclone"}, {"eigen", "fmt"}},
    {"client/editor",
     {"core/base", "client/link", "client/present", "idl", "idl/cyclone"},
     {"eigen", "fmt"}},
    {"client/gateway", {"core/base", "client/link", "idl", "idl/cyclone"}, {"fmt"}},
    {"client/cli",
     {"core/base", "client/editor", "client/gateway", "client/link", "client/present", "idl",
      "idl/cyclone", "idl/security"},
     {"eigen", "fmt"}},
    {"hardware/protocols", {"core/base"}, {}},
    {"hardware/devices", {"core/base", "hardware/protocols"}, {}},
    {"hardware/devices/examples",
     {"core/base", "hardware/devices", "hardware/protocols"},
     {"fmt"}},
    {"hardware/safety", {"core/base"}, {"fmt"}},
    {"hardware/tendon", {"core/base"}, {"eigen", "fmt"}},
    {"hardware/config", {"core/base", "hardware/safety", "hardware/tendon"}, {"eigen", "fmt"}},
    {"hardware/bridge",
     {"core/base", "idl", "idl/cyclone", "hardware/config", "hardware/devices",
      "hardware/safety", "hardware/tendon"},
     {"eigen", "fmt"}},
    {"hardware/bringup",
     {"core/base", "hardware/bridge", "hardware/config", "hardware/devices",
      "hardware/protocols", "hardware/safety"},
     {"fmt"}},
    {"hardware",
     {"core/base", "idl/cyclone", "idl/security", "hardware/bridge", "hardware/bringup",
      "hardware/config"},
     {"fmt"}},
};

/// Heavy or fragile libraries are each seen by the files named here alone.
const std::map<std::string, std::set<std::string>> users_of_one = {
    {"cgal", {"core/cloud/reconstruction.cpp", "core/hand/skin_wrap.cpp"}},
    {"nanoflann", {"core/geometry/kd_tree.cpp"}},
    {"nlopt", {"core/optimize/nlopt_solver.cpp"}},
    {"openssl",
     {"core/base/base64.cpp", "core/base/content_hash.cpp", "idl/security/certificates.cpp"}},
    {"assimp", {"core/io/scene_file.cpp"}},
    {"urdfdom", {"core/io/urdf_file.cpp"}},
    {"tinyxml2",
     {"core/io/srdf_file.cpp", "core/io/urdf_text.cpp", "hardware/bringup/make_config.cpp"}},
    {"json",
     {"core/io/contact_file.cpp",
      "core/io/contact_writer.cpp",
      "core/io/posture_json.cpp",
      "core/io/posture_json.h",
      "core/io/glb_writer.cpp",
      "core/io/grasp_writer.cpp",
      "core/io/hand_joints_file.cpp",
      "core/formats/demonstration_arrays.cpp",
      "core/formats/demonstration_text.cpp",
      "core/formats/demonstration_text.h",
      "core/formats/json_keys.cpp",
      "core/formats/json_keys.h",
      "core/io/motion_file.cpp",
      "core/io/motion_import.cpp",
      "core/io/hand_trajectory_file.cpp",
      "core/io/motion_plan.cpp",
      "core/io/problem_file.cpp",
      "core/io/session_field.h",
      "core/io/session_file.cpp",
      "core/io/session_reader.cpp",
      "core/io/session_writer.cpp",
      "core/io/session_writer.h",
      "core/io/trajectory_writer.cpp",
      "client/present/json_output.h",
      "client/link/pose_file.cpp",
      "idl/grasp_file.cpp",
      "hardware/bridge/report_line.cpp",
      "idl/json.cpp",
      "idl/json.h",
      "client/python/python_message.h",
      "client/gateway/gateway.cpp",
      "client/gateway/gateway_pages.cpp",
      "client/gateway/model_frame.cpp",
      "client/gateway/page_file.cpp"}},
    {"spdlog", {"server/log/log.cpp"}},
    {"sqlite", {"server/store/database.cpp"}},
    {"seccomp", {"server/reading/sandbox.cpp"}},
    {"beast", {"client/gateway/web_server.cpp"}},
    {"yaml", {"core/io/sites_file.cpp", "hardware/config/yaml_section.h"}},
    {"cyclone",
     {"idl/cyclone/domain.cpp", "idl/cyclone/entity.cpp", "idl/cyclone/participant.cpp",
      "idl/cyclone/quality.cpp", "idl/cyclone/written_topics.cpp"}},
    {"fastcdr", {"idl/cyclone/participant.cpp", "server/admission/packed_reply.cpp"}},
    {"pybind11",
     {"client/python/awaiting.h", "client/python/model_functions.cpp",
      "client/python/model_functions.h", "client/python/module.cpp",
      "client/python/python_message.cpp", "client/python/python_message.h"}},
    {"png", {"client/present/png_file.cpp", "core/io/png_file.cpp"}},
    {"zlib", {"core/formats/zip_file.cpp"}},
    {"editline", {"client/editor/prompt.cpp"}},
    {"cli11",
     {"server/main.cpp", "client/cli/command_line.cpp",
      "client/cli/options/bridge_commands.cpp", "client/cli/options/editor_commands.cpp",
      "client/cli/options/grasp_command.cpp", "client/cli/options/grasp_flags.cpp",
      "client/cli/options/import_commands.cpp", "client/cli/options/keys_commands.cpp",
      "client/cli/options/model_commands.cpp", "client/cli/options/model_flags.cpp",
      "client/cli/options/motion_commands.cpp", "client/cli/options/session_commands.cpp",
      "client/cli/options/study_commands.cpp", "client/cli/options/view_command.cpp",
      "hardware/main.cpp"}},
};

const std::vector<std::pair<std::string, std::regex>> library_includes = {
    {"eigen", std::regex("^(Eigen|unsupported/Eigen)/.*")},
    {"fmt", std::regex("^fmt/.*")},
    {"spdlog", std::regex("^spdlog/.*")},
    {"cgal", std::regex("^CGAL/.*")},
    {"nanoflann", std::regex("^nanoflann.hpp")},
    {"nlopt", std::regex("^nlopt.*")},
    {"openssl", std::regex("^openssl/.*")},
    {"assimp", std::regex("^assimp/.*")},
    {"urdfdom", std::regex("^(urdf_parser|urdf_model|urdf_exception|console_bridge)/.*")},
    {"tinyxml2", std::regex("^tinyxml2.h")},
    {"json", std::regex("^nlohmann/.*")},
    {"yaml", std::regex("^yaml-cpp/.*")},
    {"handgraft", std::regex("^handgraft/(client|core)\\.h")},
    {"pybind11", std::regex("^pybind11/.*")},
    {"cyclone", std::regex("^dds/(dds|ddsi|ddsrt).*")},
    {"fastcdr", std::regex("^fastcdr/.*")},
    {"fastdds", std::regex("^(fastdds|fastrtps)/.*")},
    {"png", std::regex("^png.h")},
    {"zlib", std::regex("^zlib.h")},
    {"editline", std::regex("^(histedit|editline/readline).h")},
    {"sqlite", std::regex("^sqlite3.h")},
    {"seccomp", std::regex("^seccomp.h")},
    {"cli11", std::regex("^CLI/.*")},
    {"beast", std::regex("^boost/(asio|beast)/.*")},
};

/// The standard library and the operating system.
bool isSystem(const std::string& header) {
  static const std::regex system_include(
      R"(^[a-z_0-9]+$|^(std|sys|net|arpa|netinet|linux|asm)[a-z_0-9]*(/[a-z_0-9]+)*\.h$|)"
      R"(^(cxxabi|fcntl|malloc|unistd|poll|signal|spawn|pthread|sched|ifaddrs|termios|dlfcn|link|netdb|errno|semaphore)\.h$)");
  return std::regex_match(header, system_include);
}

const Layer* layerOf(const std::string& path) {
  const Layer* best = nullptr;
  for (const Layer& layer : all_layers) {
    if (path.rfind(layer.folder + "/", 0) != 0) continue;
    if (best == nullptr || layer.folder.size() > best->folder.size()) best = &layer;
  }
  return best;
}

bool permits(const Layer& layer, const std::string& header) {
  const Layer* target = layerOf(header);
  const std::string folder =
      target != nullptr ? target->folder : fs::path(header).parent_path().string();
  if (folder == layer.folder) return true;
  const bool is_server = layer.folder == "server";
  if (is_server && (folder.rfind("core/", 0) == 0 || folder == "idl" ||
                    folder == "server/transport" || folder == "server/reading"))
    return true;
  return std::find(layer.ours.begin(), layer.ours.end(), folder) != layer.ours.end();
}

/// Empty if `path` may include `header`, else the reason why not.
std::string objection(const std::string& path, const std::string& header, bool quoted) {
  const Layer* layer = layerOf(path);
  if (layer == nullptr) return "lies in no folder of the table";
  if (quoted)
    return permits(*layer, header) ? "" : "is not in the table's row " + layer->folder;
  if (isSystem(header)) return "";
  for (const auto& [library, pattern] : library_includes) {
    if (!std::regex_match(header, pattern)) continue;
    if (const auto alone = users_of_one.find(library); alone != users_of_one.end()) {
      return alone->second.count(path) != 0 ? "" : library + " is for other files alone";
    }
    const auto& permitted = layer->libraries;
    return std::find(permitted.begin(), permitted.end(), library) != permitted.end()
               ? ""
               : library + " is not for " + layer->folder;
  }
  return "is of no library in the table";
}

struct Include {
  std::string path;
  int line;
  std::string header;
  bool quoted;
};

std::vector<Include> includesBelow(const fs::path& root) {
  static const std::regex include_line(R"rx(^\s*#\s*include\s*(["<])([^">]+)[">].*)rx");
  std::vector<Include> includes;
  for (const char* top : {"core", "idl", "server", "client", "hardware"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      std::string text;
      for (int line = 1; std::getline(file, text); ++line) {
        std::smatch match;
        if (!std::regex_match(text, match, include_line)) continue;
        includes.push_back({fs::relative(entry.path(), root).string(), line, match[2].str(),
                            match[1].str() == "\""});
      }
    }
  }
  return includes;
}

TEST(Layering, FoldersIncludeOnlyWhatTheTablePermits) {
  const std::vector<Include> includes = includesBelow(HANDGRAFT_SOURCE_DIR);
  ASSERT_GT(includes.size(), 100u) << "the sources were not found";
  for (const Include& include : includes) {
    const std::string reason = objection(include.path, include.header, include.quoted);
    EXPECT_EQ(reason, "") << include.path << ":" << include.line << " includes "
                          << include.header;
  }
}

/// Folders that include one another in a circle, "a > b > a"; empty if there are none.
std::string circleIn(const std::vector<Include>& includes) {
  std::map<std::string, std::set<std::string>> used;
  for (const Include& include : includes) {
    const std::string from = fs::path(include.path).parent_path().string();
    const std::string to = fs::path(include.header).parent_path().string();
    if (include.quoted && from != to) used[from].insert(to);
  }
  std::set<std::string> done;
  std::vector<std::string> way;
  const std::function<std::string(const std::string&)> follow =
      [&](const std::string& folder) -> std::string {
    const auto met = std::find(way.begin(), way.end(), folder);
    if (met != way.end()) {
      std::string circle;
      for (auto at = met; at != way.end(); ++at)
        circle += *at + " > ";
      return circle + folder;
    }
    way.push_back(folder);
    if (const auto next = used.find(folder); done.insert(folder).second && next != used.end()) {
      for (const std::string& each : next->second)
        if (std::string circle = follow(each); !circle.empty()) return circle;
    }
    way.pop_back();
    return "";
  };
  for (const auto& [folder, others] : used)
    if (std::string circle = follow(folder); !circle.empty()) return circle;
  return "";
}

TEST(Layering, NoFoldersIncludeOneAnotherInACircle) {
  EXPECT_EQ(circleIn(includesBelow(HANDGRAFT_SOURCE_DIR)), "");
}

TEST(Layering, ACircleIsFound) {
  const std::vector<Include> chain = {{"a/x.h", 1, "b/y.h", true},
                                      {"b/y.h", 1, "c/z.h", true},
                                      {"a/x.h", 2, "c/z.h", true},
                                      {"c/z.h", 1, "c/w.h", true}};
  EXPECT_EQ(circleIn(chain), "");
  std::vector<Include> circle = chain;
  circle.push_back({"c/w.cpp", 1, "b/other.h", true});
  EXPECT_EQ(circleIn(circle), "b > c > b");
}

TEST(Layering, EveryFileNamedAloneExists) {
  for (const auto& [library, files] : users_of_one) {
    for (const std::string& file : files) {
      EXPECT_TRUE(fs::exists(fs::path(HANDGRAFT_SOURCE_DIR) / file)) << library << ": " << file;
    }
  }
}

TEST(Layering, TheRulesCanObject) {
  EXPECT_NE(objection("core/geometry/a.cpp", "core/hand/skin.h", true), "");
  EXPECT_NE(objection("core/optimize/solver.cpp", "nlopt.hpp", false), "");
  EXPECT_NE(objection("client/cli/main.cpp", "fastdds/dds/topic/Topic.hpp", false), "");
  EXPECT_NE(objection("core/base/a.h", "boost/any.hpp", false), "");
  EXPECT_NE(objection("elsewhere/a.h", "core/base/pose.h", true), "");
  EXPECT_EQ(objection("core/hand/a.cpp", "core/geometry/log_map.h", true), "");
  EXPECT_EQ(objection("core/optimize/nlopt_solver.cpp", "nlopt.hpp", false), "");
  EXPECT_EQ(objection("server/handlers/a.cpp", "core/io/urdf_file.h", true), "");
}

}  // namespace
