#pragma once

#include "client/editor/grammar.h"
#include "client/editor/scene.h"
#include "idl/edits.h"

/// From the values of a command to the edit that it asks for, one function a row of the command
/// table. Errors of each: InvalidInput, naming the thing, its value and what it may be; and
/// those of the scene.
namespace handgraft::client::editor {

// === Patches
v1::EditBody rootOnSite(const Match& match, Scene& scene);
v1::EditBody rootOnFace(const Match& match, Scene& scene);
v1::EditBody rootNearPoint(const Match& match, Scene& scene);
v1::EditBody turn(const Match& match, Scene& scene);
v1::EditBody turnOnSide(const Match& match, Scene& scene);
v1::EditBody enable(const Match& match, Scene& scene);
v1::EditBody disable(const Match& match, Scene& scene);
v1::EditBody patchWeight(const Match& match, Scene& scene);
v1::EditBody weights(const Match& match, Scene& scene);

// === Joints
v1::EditBody jointValue(const Match& match, Scene& scene);
v1::EditBody lock(const Match& match, Scene& scene);
v1::EditBody unlock(const Match& match, Scene& scene);
v1::EditBody soft(const Match& match, Scene& scene);
v1::EditBody softOff(const Match& match, Scene& scene);
v1::EditBody limitLower(const Match& match, Scene& scene);
v1::EditBody limitUpper(const Match& match, Scene& scene);
v1::EditBody limitRange(const Match& match, Scene& scene);
v1::EditBody limitReset(const Match& match, Scene& scene);

// === Pose
v1::EditBody drag(const Match& match, Scene& scene);
v1::EditBody release(const Match& match, Scene& scene);
v1::EditBody releaseAll(const Match& match, Scene& scene);
v1::EditBody palm(const Match& match, Scene& scene);
v1::EditBody palmTurned(const Match& match, Scene& scene);
v1::EditBody place(const Match& match, Scene& scene);
v1::EditBody placeTurned(const Match& match, Scene& scene);
v1::EditBody priorRest(const Match& match, Scene& scene);
v1::EditBody priorHere(const Match& match, Scene& scene);
v1::EditBody priorPose(const Match& match, Scene& scene);
v1::EditBody priorShares(const Match& match, Scene& scene);
v1::EditBody priorPosture(const Match& match, Scene& scene);

// === Models and search
v1::EditBody hand(const Match& match, Scene& scene);
v1::EditBody object(const Match& match, Scene& scene);
v1::EditBody solver(const Match& match, Scene& scene);
v1::EditBody solverOfPaper(const Match& match, Scene& scene);
v1::EditBody choose(const Match& match, Scene& scene);

// === Of a motion
v1::EditBody takeBack(const Match& match, Scene& scene);

// === History
v1::EditBody undo(const Match& match, Scene& scene);
v1::EditBody redo(const Match& match, Scene& scene);
v1::EditBody snapshot(const Match& match, Scene& scene);
v1::EditBody restore(const Match& match, Scene& scene);

/// `solving` with what the options of `solver` and `solve` change of it. Errors: InvalidInput
/// for options that contradict each other and for counts out of range.
v1::SolveOptions solvingWith(v1::SolveOptions solving, const Match& match);

}  // namespace handgraft::client::editor
