#include "client/editor/command_table.h"

#include "client/editor/edit_making.h"

namespace handgraft::client::editor {

const std::vector<Command>& commandTable() {
  // clang-format off
  static const std::vector<Command> kTable = {
      // === Patches
      {"root PATCH hand pick SITE", "put a patch's root on a site of the hand", Action::kEdit, rootOnSite},
      {"root PATCH SIDE face COUNT NUMBER NUMBER NUMBER", "on a face of the object's mesh or the hand's skin, by three weights that sum to 1", Action::kEdit, rootOnFace},
      {"root PATCH SIDE at LENGTH LENGTH LENGTH", "on the surface's place nearest to a point, in the frame of the object or of the skin", Action::kEdit, rootNearPoint},
      {"dir PATCH ANGLE", "turn a patch on the hand, counter-clockwise as seen from outside", Action::kEdit, turn},
      {"dir PATCH SIDE ANGLE", "likewise on the side named", Action::kEdit, turnOnSide},
      {"enable PATCH", "have a patch count", Action::kEdit, enable},
      {"disable PATCH", "have it not count", Action::kEdit, disable},
      {"weight PATCH NUMBER", "how much a patch counts; 1 is usual", Action::kEdit, patchWeight},
      {"weights NUMBER NUMBER NUMBER", "of distance (1/m2), normal and prior in the objective", Action::kEdit, weights},
      // === Joints
      {"joint JOINT VALUE", "bend a joint: the pose becomes prior and start", Action::kEdit, jointValue},
      {"lock JOINT", "hold a joint where it is", Action::kEdit, lock},
      {"unlock JOINT", "let it move again", Action::kEdit, unlock},
      {"soft JOINT VALUE NUMBER", "hold a joint near a value, so many times as firmly as the prior does", Action::kEdit, soft},
      {"soft JOINT off", "let it go", Action::kEdit, softOff},
      {"limit JOINT lower VALUE", "set a joint's lower limit", Action::kEdit, limitLower},
      {"limit JOINT upper VALUE", "its upper limit", Action::kEdit, limitUpper},
      {"limit JOINT range VALUE VALUE", "both", Action::kEdit, limitRange},
      {"limit JOINT reset", "both as the hand's model has them", Action::kEdit, limitReset},
      // === Pose
      {"drag POINT to LENGTH LENGTH LENGTH --weight NUMBER", "move a site, a site's _tip or a link's origin to a point of the world and hold it there, 20 times as firmly as all patches together unless weighed otherwise; 0: not held", Action::kEdit, drag},
      {"release POINT", "let go the link of what was dragged", Action::kEdit, release},
      {"release", "let go all that was dragged, the palm too", Action::kEdit, releaseAll},
      {"palm to LENGTH LENGTH LENGTH", "move the palm to a point of the world and hold it there", Action::kEdit, palm},
      {"palm to LENGTH LENGTH LENGTH rpy ANGLE ANGLE ANGLE", "and turn its link: roll, pitch and yaw about the world's axes", Action::kEdit, palmTurned},
      {"place object LENGTH LENGTH LENGTH", "put the object's origin there; it keeps its rotation", Action::kEdit, place},
      {"place object LENGTH LENGTH LENGTH rpy ANGLE ANGLE ANGLE", "and turn it: roll, pitch and yaw about the world's axes", Action::kEdit, placeTurned},
      {"prior rest", "the hand's rest pose becomes prior and start; the palm stays", Action::kEdit, priorRest},
      {"prior here", "the last solution does", Action::kEdit, priorHere},
      {"prior pose FILE", "a pose from a file does: of `grasp --out`, or written by hand", Action::kEdit, priorPose},
      {"prior shares NUMBER NUMBER NUMBER", "how firmly the prior holds the palm's rotation, its place and the joints; 1 1 1 is the paper's", Action::kEdit, priorShares},
      {"prior posture NUMBER", "how firmly a first solve holds the hand's posture; 0: not at all", Action::kEdit, priorPosture},
      // === Of a motion
      {"at NUMBER", "edits from now on are of the motion's frame at that time (s)", Action::kTime},
      {"at NUMBER NUMBER", "and fade over so many seconds before and after it", Action::kTime},
      {"at all", "of all of the motion again", Action::kTime},
      {"take back COUNT", "an edit at a time of `show times`, which counts from 1, whatever was edited since", Action::kEdit, takeBack},
      // === Models and search
      {"hand HAND", "take another hand; what still fits is kept", Action::kEdit, hand},
      {"object OBJECT", "take another object, likewise", Action::kEdit, object},
      {"solver paper --normal-form FORM --avoid-penetration --touch-only", "search as the paper does from now on: one start, the prior, by mma", Action::kEdit, solverOfPaper},
      {"solver SOLVER --starts COUNT --seed COUNT --max-evaluations COUNT --normal-form FORM --avoid-penetration --touch-only", "search so from now on, also after edits; what is not named stays", Action::kEdit, solver},
      {"solve --solver SOLVER --starts COUNT --seed COUNT --max-evaluations COUNT --normal-form FORM --paper --avoid-penetration --touch-only", "search the pose, so for this once; Ctrl-C cancels", Action::kSolve},
      {"choose COUNT", "another minimum of `show minima`, which counts from 1, becomes prior and start", Action::kEdit, choose},
      // === History
      {"undo", "take back the last edit", Action::kEdit, undo},
      {"undo COUNT", "so many", Action::kEdit, undo},
      {"redo", "make what was undone again", Action::kEdit, redo},
      {"redo COUNT", "so many", Action::kEdit, redo},
      {"snapshot NAME", "remember the session as it is under a name", Action::kEdit, snapshot},
      {"restore SNAPSHOT", "make it as it was", Action::kEdit, restore},
      {"compare SNAPSHOT", "what differs between a snapshot and now", Action::kCompare},
      {"compare SNAPSHOT SNAPSHOT", "or between two", Action::kCompare},
      // === Looking
      {"show", "the last solution, patch by patch", Action::kShow},
      {"show TOPIC", "what a session is made of", Action::kShow},
      {"suggest PATCH --reach LENGTH --count COUNT --apply COUNT", "places on the hand nearby where a patch loses fewer points; --apply takes one", Action::kSuggest},
      {"watch", "follow the session until Ctrl-C", Action::kWatch},
      {"watch NUMBER", "so many seconds", Action::kWatch},
      {"png FILE", "draw the last solution from two sides", Action::kPicture},
      // === Files
      {"export FORMAT FILE", "write the last solution for other programs", Action::kExport},
      {"save FILE", "write all of the session: state, history, snapshots, log", Action::kSave},
      {"load FILE", "open a session of such a file and go on there", Action::kLoad},
      {"replay FILE", "play its log again and say whether it ends the same", Action::kReplay},
      {"!script FILE", "run the commands of a file", Action::kScript},
      // === Sessions
      {"sessions", "all sessions of the server", Action::kSessions},
      {"join", "go back to the session before this one", Action::kJoin},
      {"join SESSION", "go on in another session", Action::kJoin},
      {"close", "end the session and leave", Action::kClose},
      {"quit", "leave; so does Ctrl-D", Action::kQuit},
      {"help", "all commands", Action::kHelp},
      {"help COMMAND", "one of them", Action::kHelp},
  };
  // clang-format on
  return kTable;
}

}  // namespace handgraft::client::editor
