#include "tests/bench/retargeting/retargeting.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/environment.h"
#include "core/base/error.h"

#include "tests/bench/hand_import.h"
#include "tests/bench/retargeting/demonstration.h"
#include "tests/bench/retargeting/retargeted_grasp.h"
#include "tests/bench/retargeting/retargeting_picture.h"
#include "tests/bench/retargeting/retargeting_summary.h"
#include "tests/bench/skin_cache.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

constexpr int kQuickGrasps = 2;  // of each object
constexpr int kManyJoints = 16;

struct RetargetingArguments {
  std::string hands;
  std::vector<std::string> objects;
  std::string grasps;
  std::string demonstrator;
  std::vector<std::string> only;
  std::string cache = defaultCache().string();
  int per_object = 0;
  unsigned seed = 0;
  bool quick = false;
  bool no_baselines = false;
  std::string pictures;
  int random_pictures = 0;
  bool json = false;
};

/// Where the data lie unless somebody says. Errors: InvalidInput if nobody does.
fs::path sharedFolder(const char* below) {
  const fs::path shared = environment("HANDGRAFT_SHARED_DATA");
  if (shared.empty())
    rejectInput("--hands, --objects and --grasps, or HANDGRAFT_SHARED_DATA, must be given");
  return shared / below;
}

std::string orShared(const std::string& given, const char* below) {
  return given.empty() ? sharedFolder(below).string() : given;
}

std::vector<fs::path> objectFolders(const RetargetingArguments& arguments) {
  if (!arguments.objects.empty()) return {arguments.objects.begin(), arguments.objects.end()};
  // In the frames of DexYCB; other folders have the same objects in frames of their own.
  return {sharedFolder("objects/ycb"), sharedFolder("objects/ycb_dexycb")};
}

bool holds(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

/// Words that name a hand choose among the hands, the others among the grasps.
struct Filter {
  std::vector<std::string> of_hands;
  std::vector<std::string> of_grasps;

  static bool passes(const std::string& name, const std::vector<std::string>& words) {
    return words.empty() || std::any_of(words.begin(), words.end(), [&](const auto& word) {
             return holds(name, word);
           });
  }
};

Filter filterOf(const std::vector<std::string>& words,
                const std::vector<fs::path>& urdfs,
                const DemonstrationFile& file) {
  Filter filter;
  for (const std::string& word : words) {
    const bool of_hand = std::any_of(urdfs.begin(), urdfs.end(), [&](const fs::path& urdf) {
      return holds(urdf.stem().string(), word);
    });
    const bool of_grasp = std::any_of(file.entries().begin(), file.entries().end(),
                                      [&](const DemonstrationFile::Entry& one) {
                                        return holds(one.name() + "/", word);
                                      });
    if (!of_hand && !of_grasp)
      rejectInput("--only {}: is part of no hand's and no grasp's name", quoted(word));
    (of_hand ? filter.of_hands : filter.of_grasps).push_back(word);
  }
  return filter;
}

fs::path demonstratorOf(const RetargetingArguments& arguments,
                        const std::vector<fs::path>& urdfs,
                        const DemonstrationFile& file) {
  if (!arguments.demonstrator.empty()) return arguments.demonstrator;
  for (const fs::path& urdf : urdfs)
    if (urdf.filename().string() == file.handFile()) return urdf;
  rejectInput("--hands: has no {}, which made the grasps; say where it is: --demonstrator",
              quoted(file.handFile()));
}

std::vector<Demonstration> readDemonstrations(
    const DemonstrationFile& file,
    const std::vector<DemonstrationFile::Entry>& drawn,
    const Filter& filter,
    const MeasuredHand& demonstrator) {
  std::vector<Demonstration> demonstrations;
  for (const DemonstrationFile::Entry& entry : drawn) {
    if (!Filter::passes(entry.name() + "/", filter.of_grasps)) continue;
    try {
      demonstrations.push_back(file.read(entry, demonstrator.hand, demonstrator.carrier.get()));
    } catch (const InvalidInput& error) {
      fmt::print(stderr, "{}: left out: {}\n", entry.name(), error.what());
    }
  }
  return demonstrations;
}

/// The summary of each hand, then of those with many joints and of all, the demonstrator's own
/// left out.
std::vector<HandSummary> summariesOf(const std::vector<MeasuredHand>& hands,
                                     const MeasuredHand& demonstrator,
                                     const std::vector<RetargetedGrasp>& grasps) {
  std::vector<HandSummary> summaries;
  std::vector<const RetargetedGrasp*> of_many;
  std::vector<const RetargetedGrasp*> of_all;
  std::vector<HandSummary> own;
  for (const MeasuredHand& hand : hands) {
    const int dofs = hand.hand.model->dofCount();
    const bool is_own = hand.name == demonstrator.name;
    std::vector<const RetargetedGrasp*> of_hand;
    for (const RetargetedGrasp& grasp : grasps) {
      if (grasp.hand != hand.name) continue;
      of_hand.push_back(&grasp);
      if (is_own) continue;
      of_all.push_back(&grasp);
      if (dofs >= kManyJoints) of_many.push_back(&grasp);
    }
    (is_own ? own : summaries)
        .push_back(summarise(is_own ? hand.name + " onto itself" : hand.name, dofs, of_hand));
  }
  if (summaries.size() > 1) {
    if (!of_many.empty())
      summaries.push_back(
          summarise(fmt::format("all of {} joints and more", kManyJoints), 0, of_many));
    summaries.push_back(summarise("all", 0, of_all));
  }
  summaries.insert(summaries.end(), own.begin(), own.end());
  return summaries;
}

/// A figure to rank grasps by, lower is better: millimetres off and inside, and a centimetre
/// for all patches out of reach.
double badness(const RetargetedGrasp& grasp) {
  const GraspMeasure& measure = grasp.ours.measure;
  const double missed =
      grasp.asked == 0 ? 1.0 : 1.0 - static_cast<double>(measure.reached) / grasp.asked;
  return measure.mean_mm + 1e3 * measure.penetration.deepest() + 10.0 * missed;
}

/// The best, the median and the worst grasp, and so many drawn at random; each under a name
/// that says which.
std::vector<std::pair<std::string, const RetargetedGrasp*>> chosenForPictures(
    const std::vector<RetargetedGrasp>& grasps, int random_count, unsigned seed) {
  std::vector<const RetargetedGrasp*> posed;
  for (const RetargetedGrasp& grasp : grasps)
    if (grasp.refused.empty()) posed.push_back(&grasp);
  std::vector<std::pair<std::string, const RetargetedGrasp*>> chosen;
  if (posed.empty()) return chosen;
  std::mt19937 random(seed);
  std::vector<const RetargetedGrasp*> left = posed;
  for (int i = 0; i < random_count && !left.empty(); ++i) {
    const std::size_t at = random() % left.size();
    chosen.emplace_back(fmt::format("random_{:02}", i + 1), left[at]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
  }
  std::stable_sort(posed.begin(), posed.end(),
                   [](const RetargetedGrasp* a, const RetargetedGrasp* b) {
                     return badness(*a) < badness(*b);
                   });
  chosen.emplace_back("best", posed.front());
  chosen.emplace_back("median", posed[posed.size() / 2]);
  chosen.emplace_back("worst", posed.back());
  return chosen;
}

void draw(const RetargetingArguments& arguments,
          const std::vector<MeasuredHand>& hands,
          const MeasuredHand& demonstrator,
          const std::vector<Demonstration>& demonstrations,
          const std::vector<RetargetedGrasp>& grasps) {
  for (const auto& chosen :
       chosenForPictures(grasps, arguments.random_pictures, arguments.seed)) {
    const auto& name = chosen.first;
    const RetargetedGrasp* const grasp = chosen.second;
    const auto hand = std::find_if(hands.begin(), hands.end(), [&](const MeasuredHand& one) {
      return one.name == grasp->hand;
    });
    const auto demonstration = std::find_if(demonstrations.begin(), demonstrations.end(),
                                            [&](const Demonstration& one) {
                                              return one.name == grasp->grasp;
                                            });
    const fs::path file = fs::path(arguments.pictures) / (name + ".png");
    drawGrasp(file, *hand, demonstrator, *demonstration, *grasp);
    fmt::print(stderr, "{}: {} grasps {}\n", file.string(), grasp->hand, grasp->grasp);
  }
}

void run(const RetargetingArguments& arguments) {
  const DemonstrationFile file(orShared(arguments.grasps, "contacts/dexycb/dexycb_grasps.json"),
                               objectFolders(arguments));
  const std::vector<fs::path> urdfs = urdfsIn({orShared(arguments.hands, "hands")});
  const Filter filter = filterOf(arguments.only, urdfs, file);
  const MeasuredHand demonstrator =
      readMeasuredHand(demonstratorOf(arguments, urdfs, file), arguments.cache);
  const int per_object =
      arguments.quick && arguments.per_object == 0 ? kQuickGrasps : arguments.per_object;
  const std::vector<Demonstration> demonstrations =
      readDemonstrations(file, file.draw(per_object, arguments.seed), filter, demonstrator);
  fmt::print(stderr, "{} grasps of {} read\n", demonstrations.size(), demonstrator.name);

  std::vector<MeasuredHand> hands;
  std::vector<RetargetedGrasp> grasps;
  for (const fs::path& urdf : urdfs) {
    if (!Filter::passes(urdf.stem().string(), filter.of_hands)) continue;
    try {
      hands.push_back(urdf.stem().string() == demonstrator.name
                          ? demonstrator
                          : readMeasuredHand(urdf, arguments.cache));
    } catch (const InvalidInput& error) {
      fmt::print(stderr, "{}: left out: {}\n", urdf.string(), error.what());
      continue;
    }
    for (std::size_t i = 0; i < demonstrations.size(); ++i) {
      grasps.push_back(
          retarget(hands.back(), demonstrator, demonstrations[i], !arguments.no_baselines));
      fmt::print(stderr, "\r{}: {} of {} grasps ", hands.back().name, i + 1,
                 demonstrations.size());
    }
    fmt::print(stderr, "\n");
  }
  if (!arguments.pictures.empty()) draw(arguments, hands, demonstrator, demonstrations, grasps);
  const std::vector<HandSummary> summaries = summariesOf(hands, demonstrator, grasps);
  const std::string text =
      arguments.json ? jsonOf(summaries, grasps) + "\n" : markdownOf(summaries);
  std::fputs(text.c_str(), stdout);
}

}  // namespace

void addRetargetingCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "retargeting",
      "A human's recorded grasps on every hand, all defaults, beside what is used today");
  const auto arguments = std::make_shared<RetargetingArguments>();
  command->add_option("--hands", arguments->hands,
                      "Folder of URDFs; unless given, that of HANDGRAFT_SHARED_DATA");
  command->add_option("--objects", arguments->objects,
                      "Folders of meshes, or of folders of them, named as the grasps' objects");
  command->add_option("--grasps", arguments->grasps, "JSON file of a posed hand's grasps");
  command->add_option("--demonstrator", arguments->demonstrator,
                      "URDF that the grasps are of; unless given, the one of --hands that the "
                      "file names");
  command->add_option("--only", arguments->only,
                      "Parts of names: of hands, and of grasps (025_mug, 025_mug/3/)");
  command->add_option("--cache", arguments->cache, "Folder that keeps skins and wraps")
      ->capture_default_str();
  command
      ->add_option("--per-object", arguments->per_object,
                   "So many grasps of each object, drawn by --seed; 0: all")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "Which of them")->capture_default_str();
  command->add_flag("--quick", arguments->quick, "Two grasps of each object");
  command->add_flag("--no-baselines", arguments->no_baselines, "Contact transfer alone");
  command->add_option("--pictures", arguments->pictures,
                      "Folder for pictures of the best, the median and the worst grasp");
  command
      ->add_option("--random", arguments->random_pictures,
                   "So many more, drawn at random by --seed")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "One JSON document, with every grasp");
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
