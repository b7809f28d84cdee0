#include "core/hand/part_words.h"

#include <gtest/gtest.h>

namespace handgraft::hand {
namespace {

struct Case {
  const char* name;
  const char* digit;
  const char* segment;
};

/// How hands in the field name their links and joints.
TEST(PartWords, KnowTheNamesOfTheField) {
  const Case cases[] = {
      {"ffdistal", "index", "distal"},
      {"rh_ffdistal", "index", "distal"},
      {"thmiddle", "thumb", "middle"},
      {"lh_THJ1", "thumb", ""},
      {"LFJ5", "little", ""},
      {"lfmetacarpal", "little", "metacarpal"},
      {"FFtip", "index", "distal"},
      {"mfknuckle", "middle", "proximal"},
      {"link_rf_pm_z", "ring", "proximal"},
      {"link_th_dd_z", "thumb", "distal"},
      {"thumb_proximal_base", "thumb", "proximal"},
      {"index_intermediate", "index", "middle"},
      {"pinky_tip", "little", "distal"},
      {"R_thumb_distal_joint", "thumb", "distal"},
      {"right_hand_Index_Finger_Proximal", "index", "proximal"},
      {"right_hand_Thumb_Opposition", "thumb", ""},
      {"index_L2", "index", ""},
      {"thumb_fingertip", "thumb", "distal"},
      {"rightPinky2", "little", ""},
      {"middle_finger_1", "middle", ""},
      {"middle_distal", "middle", "distal"},
      {"index_middle", "index", "middle"},
      {"mid1", "middle", ""},
      {"mid_prox", "middle", "proximal"},
      {"ring_mid", "ring", "middle"},
      {"thumb_sensor", "thumb", ""},
      {"palm_lower", "palm", ""},
      {"if_proximal_link", "index", "proximal"},
      {"ifmiddle", "index", "middle"},
      {"IFJ2", "index", ""},
  };
  for (const Case& one : cases) {
    const PartWords words = partWordsOf(one.name);
    EXPECT_EQ(words.digit, one.digit) << one.name;
    EXPECT_EQ(words.segment, one.segment) << one.name;
  }
}

TEST(PartWords, KnowFingersInOtherLanguages) {
  const Case cases[] = {
      {"pulgar_distal", "thumb", "distal"},
      {"dedo_indice", "index", ""},
      {"dedo_\u00edndice", "index", ""},
      {"\u00cdndice2", "index", ""},
      {"medio_distal", "middle", "distal"},
      {"pulgar_medio", "thumb", "middle"},
      {"coraz\u00f3n", "middle", ""},
      {"corazo\u0301n", "middle", ""},
      {"anular_1", "ring", ""},
      {"me\u00f1ique", "little", ""},
      {"menique_tip", "little", "distal"},
      {"pouce_base", "thumb", ""},
      {"Majeur1", "middle", ""},
      {"annulaire", "ring", ""},
      {"auriculaire_distal", "little", "distal"},
      {"DaumenGlied", "thumb", ""},
      {"daumenspitze", "thumb", ""},
      {"Zeigefinger_2", "index", ""},
      {"ZeigeFinger2", "index", ""},
      {"mittelfinger", "middle", ""},
      {"Ringfinger", "ring", ""},
      {"kleiner_finger_1", "little", ""},
      {"KleinerFinger", "little", ""},
      {"pollice_distal", "thumb", "distal"},
      {"anulare", "ring", ""},
      {"mignolo", "little", ""},
      {"right_muzhi_1", "thumb", ""},
      {"ShizhiDistal", "index", "distal"},
      {"zhongzhi_2", "middle", ""},
      {"wumingzhi_joint", "ring", ""},
      {"xiaomuzhi", "little", ""},
  };
  for (const Case& one : cases) {
    const PartWords words = partWordsOf(one.name);
    EXPECT_EQ(words.digit, one.digit) << one.name;
    EXPECT_EQ(words.segment, one.segment) << one.name;
  }
}

TEST(PartWords, FindNoFingerInsideOtherWords) {
  for (const char* name : {"indices", "annular_gear", "majeure", "mediolateral", "pulgarcito",
                           "kleiner_link", "mittel_link", "poucet", "vindice", "intermedio"})
    EXPECT_EQ(partWordsOf(name).digit, "") << name;

  for (const char* name : {"",
                           "wrist",
                           "spring",
                           "bearing_3",
                           "offset",
                           "4th_link",
                           "link_12.0",
                           "forearm",
                           "right_hand_e2",
                           "right_hand_t",
                           "link_3.0_tip",
                           "finger_2_med_link",
                           "f1_middle",
                           "digit3_middle",
                           "fingertip_2",
                           "mcp_joint",
                           "dip",
                           "base_link",
                           "thrust",
                           "iffy_link",
                           "offering",
                           "\xff\xfe"})
    EXPECT_EQ(partWordsOf(name).digit, "") << name;
}

TEST(PartWords, TellSegmentsOfNumberedFingers) {
  EXPECT_EQ(partWordsOf("finger_2_med_link").segment, "middle");
  EXPECT_EQ(partWordsOf("f1_middle").segment, "middle");
  EXPECT_EQ(partWordsOf("finger_1_dist_joint").segment, "distal");
}

TEST(PartWords, TellTheSide) {
  EXPECT_EQ(partWordsOf("rh_ffdistal").side, "right");
  EXPECT_EQ(partWordsOf("left_hand_a").side, "left");
  EXPECT_EQ(partWordsOf("L_index_proximal").side, "left");
  EXPECT_EQ(partWordsOf("index_L2").side, "");
  EXPECT_EQ(partWordsOf("lfdistal").side, "");
}

TEST(PartWords, PartASidesLetterFromWhatFollows) {
  EXPECT_EQ(partWordsOf("LThumb1Link").digit, "thumb");
  EXPECT_EQ(partWordsOf("LThumb1Link").side, "left");
  EXPECT_EQ(partWordsOf("RIndexDistal").digit, "index");
  EXPECT_EQ(partWordsOf("RIndexDistal").segment, "distal");
  EXPECT_EQ(partWordsOf("rpinky_2").digit, "little");
  EXPECT_EQ(partWordsOf("RFinger11").side, "right");
  EXPECT_EQ(partWordsOf("LHand").side, "left");
  for (const char* name : {"LFDistal", "lfdistal", "RFJ1", "rfknuckle"})
    EXPECT_EQ(partWordsOf(name).side, "") << name;
  for (const char* name : {"lite", "rth", "rlink_2", "large"})
    EXPECT_EQ(partWordsOf(name).digit, "") << name;
}

TEST(PartWords, CallAMiddleAloneVague) {
  EXPECT_TRUE(partWordsOf("middle").is_vague);
  EXPECT_FALSE(partWordsOf("middle_distal").is_vague);
  EXPECT_FALSE(partWordsOf("mfdistal").is_vague);
}

}  // namespace
}  // namespace handgraft::hand
