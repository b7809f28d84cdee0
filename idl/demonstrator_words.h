#pragma once

/// What a session's message says of whoever its hand follows, as far as programs have to tell
/// it apart: `demonstrator: values: ...`.
namespace handgraft::idl {

inline constexpr const char* kOfDemonstrator = "demonstrator: ";
/// After it: a frame is right, but the hand has not begun. Anything else is a refusal.
inline constexpr const char* kTouchesTooLittle = "touches the object with";
/// After it: somebody else's frames are followed.
inline constexpr const char* kAnotherIsFollowed = "another one is followed";

}  // namespace handgraft::idl
