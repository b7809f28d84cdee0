#include "client/cli/study/study_notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::HandDescription rightHand() {
  v1::HandDescription hand;
  hand.chirality(v1::CHIRALITY_RIGHT);
  hand.notes({"its skin crosses itself"});
  return hand;
}

StudyContacts contactsOf(const std::string& label,
                         v1::Chirality touched,
                         const std::vector<std::string>& notes) {
  StudyContacts contacts{label, {}};
  contacts.described.demonstrator(touched);
  contacts.described.notes(notes);
  return contacts;
}

TEST(StudyNotes, TellThatTheOtherHandTouched) {
  EXPECT_THAT(notesOn(rightHand(), {contactsOf("cup", v1::CHIRALITY_LEFT, {})}),
              ElementsAre("its skin crosses itself",
                          HasSubstr("a left hand touched, and this is a right one")));
  EXPECT_THAT(notesOn(rightHand(), {contactsOf("cup", v1::CHIRALITY_RIGHT, {}),
                                    contactsOf("box", v1::CHIRALITY_UNKNOWN, {})}),
              ElementsAre("its skin crosses itself"));
}

TEST(StudyNotes, TellWhatIsOfAllOnceAndNameTheOthers) {
  EXPECT_THAT(
      notesOn(rightHand(), {contactsOf("cup", v1::CHIRALITY_UNKNOWN, {"scanned", "open"}),
                            contactsOf("box", v1::CHIRALITY_UNKNOWN, {"scanned"})}),
      ElementsAre("its skin crosses itself", "scanned", "cup: open"));
}

TEST(StudyNotes, TellWhichFingerTookWhat) {
  StudyContacts cup = contactsOf("cup", v1::CHIRALITY_UNKNOWN, {"scanned"});
  cup.dealt = {"scanned", "patch 'ring' is left out: the hand has no such finger"};
  EXPECT_THAT(
      notesOn(rightHand(), {cup, contactsOf("box", v1::CHIRALITY_UNKNOWN, {"scanned"})}),
      ElementsAre("its skin crosses itself", "scanned",
                  "cup: patch 'ring' is left out: the hand has no such finger"));
}

}  // namespace
}  // namespace handgraft::client
