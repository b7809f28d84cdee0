// Messages as JSON: every message survives the way there and back; every damage is told by
// path.
#include "idl/json.h"

#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "idl/check.h"
#include "idl/edits.h"
#include "idl/hardware.h"
#include "idl/service.h"

#include "tests/idl/random_message.h"

namespace handgraft {
namespace {

using idl::Field;
using idl::Json;
using idl::Kind;
using idl::Type;
using testing::HasSubstr;

constexpr unsigned kSeeds = 20;

/// What is wrong with `json`, by the path that is named; empty: nothing.
std::string wrongIn(const Json& json, const std::function<void(const Json&)>& read) {
  try {
    read(json);
  } catch (const idl::InvalidField& e) {
    EXPECT_EQ(std::string(e.what()).find(e.path() + ": "), 0u);
    return e.path();
  }
  return "";
}

/// A message's JSON, and every way to damage it.
class Damages {
 public:
  Damages(const Type& type, Json json, std::function<void(const Json&)> read)
      : json_(std::move(json)), read_(std::move(read)) {
    object(type, json_, "");
  }

  [[nodiscard]] int count() const { return count_; }

 private:
  /// With `place` being `damaged` instead, `path` is what is wrong.
  void expect(Json& place, const Json& damaged, const std::string& path) {
    const Json sound = place;
    place = damaged;
    EXPECT_EQ(wrongIn(json_, read_), path) << "with " << damaged << " for " << sound;
    place = sound;
    ++count_;
  }

  void object(const Type& type, Json& place, const std::string& path) {
    Json more = place;
    more["no_such_field"] = 1;
    expect(place, more, idl::memberPath(path, "no_such_field"));
    if (!path.empty()) expect(place, Json::array(), path);
    if (type.kind == Kind::kUnion) {
      expect(place["kind"], "no_such_kind", idl::memberPath(path, "kind"));
      const auto label = idl::valueOf(*type.discriminator, place["kind"].get<std::string>());
      const Field* chosen = idl::chosenOf(type, *label);
      if (place.contains(chosen->name))
        value(*chosen->type, *chosen, place[chosen->name], idl::memberPath(path, chosen->name));
      return;
    }
    for (const Field& field : type.fields) {
      ASSERT_TRUE(place.contains(field.name)) << path << " lacks " << field.name;
      value(*field.type, field, place[field.name], idl::memberPath(path, field.name));
    }
  }

  void value(const Type& type, const Field& field, Json& place, const std::string& path) {
    switch (type.kind) {
      case Kind::kStruct:
      case Kind::kUnion:
        return object(type, place, path);
      case Kind::kSequence:
      case Kind::kArray:
        return list(type, field, place, path);
      case Kind::kEnum:
        expect(place, "no_such_name", path);
        return expect(place, 0, path);
      case Kind::kString:
        return expect(place, 1, path);
      case Kind::kBoolean:
        return expect(place, 1, path);
      case Kind::kFloat:
        expect(place, 1e39, path);
        [[fallthrough]];
      case Kind::kDouble:
        expect(place, "far", path);
        if (!field.type->isOptional()) expect(place, nullptr, path);
        if (!field.nan) expect(place, "nan", path);
        if (!field.infinite) expect(place, "-inf", path);
        break;
      default:
        expect(place, 0.5, path);
        expect(place, -1e30, path);
        expect(place, true, path);
        if (type.kind == Kind::kUint32) expect(place, 4294967296, path);
        if (type.kind == Kind::kUint64) expect(place, "18446744073709551616", path);
        break;
    }
    if (field.most < 1e30) expect(place, 2.0 * field.most + 1.0, path);
    if (field.least > -1e30) expect(place, field.least - 1.0, path);
  }

  void list(const Type& type, const Field& field, Json& place, const std::string& path) {
    expect(place, type.isOptional() ? Json::array() : Json(7), path);
    if (type.element->kind == Kind::kOctet) {
      expect(place, "0", path);
      expect(place, "zz", path);
      if (type.kind == Kind::kArray) expect(place, place.get<std::string>() + "00", path);
      return;
    }
    if (type.isOptional()) {
      if (!place.is_null()) value(*type.element, field, place, path);
      return;
    }
    if (type.kind == Kind::kArray) {
      Json longer = place;
      longer.push_back(place[0]);
      expect(place, longer, path);
      expect(place, Json::array(), path);
    } else if (type.bound > 0 && type.bound < 100) {
      Json longer = Json::array();
      for (std::size_t i = 0; i <= type.bound; ++i)
        longer.push_back(nullptr);
      expect(place, longer, path);
    }
    for (std::size_t i = 0; i < place.size(); ++i)
      value(*type.element, field, place[i], path + "[" + std::to_string(i) + "]");
  }

  Json json_;
  std::function<void(const Json&)> read_;
  int count_ = 0;
};

struct Case {
  const char* name = nullptr;
  void (*survives)(unsigned seed) = nullptr;
  int (*damage)(unsigned seed) = nullptr;

  // NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
  friend void PrintTo(const Case& one, std::ostream* out) { *out << one.name; }
};

template <class Message>
void survives(unsigned seed) {
  const Message message = test::RandomMessage(seed).make<Message>();
  EXPECT_NO_THROW(idl::check(message));
  const std::string text = idl::jsonText(message, seed % 3 == 0 ? 2 : -1);
  EXPECT_TRUE(idl::fromJsonText<Message>(text) == message) << text;

  // Nothing of it is left out; without any of its fields but lists, something is.
  const Type& type = idl::typeOf<Message>();
  const Json json = idl::jsonOf(message);
  EXPECT_NO_THROW(idl::requireWhole(type, json, ""));
  for (const Field& field : type.fields) {
    Json less = json;
    if (type.kind == Kind::kUnion || less.erase(field.name) == 0) continue;
    EXPECT_EQ(wrongIn(less,
                      [&](const Json& part) {
                        idl::requireWhole(type, part, "");
                      }),
              field.type->kind == Kind::kSequence ? "" : field.name);
  }
}

template <class Message>
int damage(unsigned seed) {
  const auto message = test::RandomMessage(seed).make<Message>();
  return Damages(idl::typeOf<Message>(), idl::jsonOf(message),
                 [](const Json& json) {
                   idl::fromJson<Message>(json);
                 })
      .count();
}

class EveryMessage : public testing::TestWithParam<Case> {};

TEST_P(EveryMessage, SurvivesJson) {
  for (unsigned seed = 0; seed < kSeeds; ++seed)
    GetParam().survives(seed);
}

TEST_P(EveryMessage, NamesThePathOfEveryDamage) {
  for (unsigned seed = 0; seed < kSeeds; ++seed)
    EXPECT_GT(GetParam().damage(seed), 0);
}

#define HANDGRAFT_CASE(Name) Case{#Name, survives<v1::Name>, damage<v1::Name>},
INSTANTIATE_TEST_SUITE_P(V1,
                         EveryMessage,
                         testing::ValuesIn(std::vector<Case>{
                             HANDGRAFT_EACH_MESSAGE(HANDGRAFT_CASE)}),
                         [](const auto& one) {
                           return std::string(one.param.name);
                         });

// === The form itself

TEST(MessageJson, WritesKeysInTheOrderOfTheIdl) {
  v1::JointLimit limit;
  limit.joint("thumb_mcp");
  limit.side(v1::LIMIT_UPPER);
  EXPECT_EQ(idl::jsonText(limit), R"({"joint":"thumb_mcp","side":"upper"})");
}

TEST(MessageJson, WritesAUnionAsItsKindAndItsMember) {
  v1::EditBody body;
  v1::StepsEdit steps;
  steps.count(3);
  body.steps(steps);
  body._d(v1::EDIT_REDO);
  EXPECT_EQ(idl::jsonText(body), R"({"kind":"redo","steps":{"count":3}})");
  v1::RequestBody list;
  list.nothing(v1::Nothing());
  list._d(v1::OP_LIST_MODELS);
  EXPECT_EQ(idl::jsonText(list), R"({"kind":"list_models"})");
  EXPECT_TRUE(idl::fromJsonText<v1::RequestBody>(R"({"kind": "list_models"})") == list);
}

TEST(MessageJson, WritesOptionalValuesAsThemselvesOrNull) {
  v1::EditReply reply;
  v1::Edit edit;
  EXPECT_EQ(idl::jsonOf(edit)["when"], nullptr);
  edit.when().emplace_back();
  edit.when().front().time_s(2.5);
  EXPECT_EQ(idl::jsonOf(edit)["when"]["time_s"], 2.5);
}

TEST(MessageJson, KeepsWhatJsonHasNoNumbersFor) {
  v1::JointInfo joint;
  joint.lower(-INFINITY);
  EXPECT_EQ(idl::jsonOf(joint)["lower"], "-inf");
  v1::Difference difference;
  difference.change(std::nan(""));
  const Json json = idl::jsonOf(difference);
  EXPECT_EQ(json["change"], "nan");
  EXPECT_TRUE(std::isnan(idl::fromJson<v1::Difference>(json).change()));
  v1::SessionKey key;
  key.session_id((1ULL << 63U) + 1);
  EXPECT_EQ(idl::jsonText(key), R"({"session_id":"9223372036854775809"})");
  EXPECT_EQ(idl::fromJsonText<v1::SessionKey>(R"({"session_id": "12"})").session_id(), 12u);
}

TEST(MessageJson, LeavesOutWhatIsNotSaid) {
  const auto request = idl::fromJsonText<v1::SuggestRequest>(R"({"patch": "thumb"})");
  EXPECT_EQ(request.patch(), "thumb");
  EXPECT_EQ(request.count(), 0u);
}

TEST(MessageJson, RefusesWhatIsNoJsonOrNoObject) {
  for (const char* text : {"", "{", "[]", "3", "{\"patch\": }"}) {
    EXPECT_THROW(idl::fromJsonText<v1::SuggestRequest>(text), InvalidInput) << text;
  }
}

TEST(MessageJson, NumbersThatFitNoFieldAreToldItsOwnRange) {
  try {
    idl::fromJsonText<v1::SolveOptions>(R"({"starts": -1})");
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("starts: -1 is outside 0 to 10000"));
  }
  try {
    idl::fromJsonText<v1::SolveOptions>(R"({"seed": -1})");
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("seed: -1 is outside 0 to 4294967295"));
  }
}

// === Checks of messages from the wire

TEST(MessageCheck, NamesTheFieldItsValueAndTheRange) {
  v1::Request request;
  v1::OptimizeRequest optimize;
  optimize.options().emplace_back();
  optimize.options().front().starts(10'001);
  request.body().optimize(optimize);
  try {
    idl::check(request);
    FAIL();
  } catch (const idl::InvalidField& e) {
    EXPECT_EQ(e.path(), "body.optimize.options[0].starts");
    EXPECT_THAT(e.what(), HasSubstr("10001 is outside 0 to 10000"));
  }
}

TEST(MessageCheck, RefusesWhatTheVendorsLetThrough) {
  const auto wrong = [](const auto& message) {
    try {
      idl::check(message);
    } catch (const idl::InvalidField& e) {
      return e.path();
    }
    return std::string();
  };
  v1::Reply reply;
  reply.error(static_cast<v1::ErrorCode>(99));
  EXPECT_EQ(wrong(reply), "error");
  v1::PatchWeightEdit weight;
  weight.weight(std::nan(""));
  EXPECT_EQ(wrong(weight), "weight");
  v1::OpenSessionRequest open;
  open.X_WO().resize(2);
  EXPECT_EQ(wrong(open), "X_WO");
  v1::Pose pose;
  pose.q_wxyz()[3] = INFINITY;
  EXPECT_EQ(wrong(pose), "q_wxyz[3]");
}

}  // namespace
}  // namespace handgraft
