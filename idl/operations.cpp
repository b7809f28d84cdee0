#include "idl/operations.h"

#include <algorithm>
#include <iterator>

#include "idl/fields.h"

namespace handgraft::idl {

namespace {

constexpr auto kLook = Privilege::kLook;
constexpr auto kEdit = Privilege::kEdit;
constexpr auto kOperate = Privilege::kOperate;
constexpr auto kAny = AnsweredBy::kAnyServer;
constexpr auto kOne = AnsweredBy::kOneServer;
constexpr auto kNone = Pages::kNone;
constexpr auto kThatEdit = Pages::kThatEdit;
constexpr auto kThatLook = Pages::kThatLook;

constexpr OperationTraits kOperations[] = {
    {v1::OP_NOTHING, kLook, kAny, kNone},
    {v1::OP_PUT_FILE, kEdit, kOne, kNone},
    {v1::OP_LOAD_MODEL, kEdit, kOne, kNone},
    {v1::OP_LIST_MODELS, kLook, kAny, kThatLook},
    {v1::OP_DESCRIBE_MODEL, kLook, kAny, kNone},
    {v1::OP_UNLOAD_MODEL, kOperate, kAny, kNone},
    {v1::OP_OPEN_SESSION, kEdit, kAny, kThatEdit},
    {v1::OP_DESCRIBE_SESSION, kLook, kOne, kThatLook},
    {v1::OP_LIST_SESSIONS, kLook, kAny, kThatLook},
    {v1::OP_CLOSE_SESSION, kEdit, kOne, kNone},
    {v1::OP_TRANSFER, kLook, kOne, kThatLook},
    {v1::OP_OPTIMIZE, kEdit, kOne, kThatEdit},
    {v1::OP_EXPORT, kLook, kOne, kThatLook},
    {v1::OP_CANCEL, kLook, kOne, kNone},
    {v1::OP_SUGGEST, kEdit, kOne, kThatEdit},
    {v1::OP_POSE_CONTACTS, kEdit, kAny, kNone},
    {v1::OP_MAKE_VARIANT, kEdit, kAny, kNone},
    {v1::OP_SWEEP, kEdit, kAny, kNone},
    {v1::OP_SESSION_SETTINGS, kLook, kOne, kThatLook},
    {v1::OP_COMPARE, kLook, kOne, kThatLook},
    {v1::OP_SAVE_SESSION, kLook, kOne, kThatLook},
    {v1::OP_LOAD_SESSION, kEdit, kAny, kThatEdit},
    {v1::OP_REPLAY, kEdit, kAny, kNone},
    {v1::OP_STOP_SOLVING, kEdit, kOne, kThatEdit},
    {v1::OP_SHARE_SESSION, kEdit, kOne, kNone},
    {v1::OP_SOLVE_MOTION, kEdit, kOne, kThatEdit},
    {v1::OP_MOTION_FRAMES, kLook, kOne, kThatLook},
    {v1::OP_SET_CLOCK, kEdit, kOne, kThatEdit},
    {v1::OP_LINK_POSES, kLook, kOne, kThatLook},
};

}  // namespace

OperationTraits traitsOf(v1::Operation operation) {
  const auto* const found =
      std::find_if(std::begin(kOperations), std::end(kOperations), [&](const auto& traits) {
        return traits.operation == operation;
      });
  return found != std::end(kOperations) ? *found
                                        : OperationTraits{operation, kOperate, kOne, kNone};
}

std::uint64_t sessionOf(const v1::RequestBody& body) {
  const Field* member =
      chosenOf(typeOf<v1::RequestBody>(), static_cast<std::uint32_t>(body._d()));
  if (member == nullptr || member->type->kind != Kind::kStruct) return 0;
  const Field* id = fieldOf(*member->type, "session_id");
  if (id == nullptr) return 0;
  // Tables are made for writing, too; nothing is written here.
  void* message = member->in(const_cast<v1::RequestBody*>(&body));
  return *static_cast<const std::uint64_t*>(id->in(message));
}

}  // namespace handgraft::idl
