#include "idl/datagrams/datagram_filter.h"

#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "tests/idl/datagrams.h"

namespace handgraft::idl {
namespace {

using namespace test;

TEST(DatagramFilter, PassesWhatOurProgramsSay) {
  for (const Datagram& sound :
       {heartbeat(1, 0), heartbeat(1, 7), heartbeat(100, 2000), gap(3, 5), announcement(20),
        data(kUserWriter, 1, {0, 1, 0, 0, 42}), fragment(1, 1000, 2500, 1000),
        fragment(3, 1000, 2500, 500)})
    EXPECT_EQ(passed(sound), sound);
}

TEST(DatagramFilter, CutsOutWhatItDoesNotKnow) {
  // eProsima's statistics submessage, on which Fast DDS 2.9.1 aborts.
  Datagram attack = message(0x80, 0, Datagram(56));
  EXPECT_TRUE(passed(attack).empty());
  const Datagram sound = heartbeat(1, 7);
  attack.insert(attack.end(), sound.begin() + 20, sound.end());
  EXPECT_EQ(passed(attack), sound);
}

TEST(DatagramFilter, KnowsHowFarAWriterCanBe) {
  DatagramFilter filter;
  constexpr std::int64_t kFar = std::int64_t{1} << 60;
  EXPECT_TRUE(passed(filter, heartbeat(kFar, kFar + 3)).empty());
  EXPECT_TRUE(passed(filter, heartbeat(8, 6)).empty());
  EXPECT_TRUE(passed(filter, heartbeat(1, kFar)).empty());
  EXPECT_TRUE(passed(filter, heartbeat(-5, 7)).size() == heartbeat(1, 7).size())
      << "a first number below 1 says: nothing yet";
  EXPECT_TRUE(passed(filter, gap(1, kFar)).empty());
  EXPECT_TRUE(passed(filter, data(kUserWriter, kFar, {0, 1, 0, 0})).empty());
  EXPECT_TRUE(passed(filter, data(kUserWriter, 0, {0, 1, 0, 0})).empty());
  // One that counts on is followed wherever it gets.
  std::int64_t at = 1;
  for (int i = 0; i < 100; ++i) {
    at += DatagramFilter::kLongestJump - 1;
    ASSERT_FALSE(passed(filter, heartbeat(at, at)).empty()) << at;
  }
}

TEST(DatagramFilter, LetsParticipantsSpeakForThemselvesAlone) {
  EXPECT_FALSE(passed(announcement(DatagramFilter::kShortestLease)).empty());
  EXPECT_TRUE(passed(announcement(0)).empty());
  EXPECT_TRUE(passed(announcement(DatagramFilter::kShortestLease - 1)).empty());
  EXPECT_TRUE(passed(announcement(20, 0xb0)).empty());
}

TEST(DatagramFilter, TellsTheParticipantsOfOneProcessApart) {
  DatagramFilter filter;
  std::vector<std::uint8_t> kept;
  const auto passes = [&](const Datagram& bytes) {
    const auto passed = filter.pass(bytes, kept);
    return Datagram(passed.begin(), passed.end()) == bytes;
  };
  constexpr std::int64_t kFar = DatagramFilter::kLongestJump;
  ASSERT_TRUE(passes(heartbeat(kFar, kFar)));
  // The same writer's id, of a participant whose samples begin at 1.
  Datagram two = heartbeat(kFar + 1, kFar + 1);
  addSource(two, 0x11);
  addSubmessagesOf(two, heartbeat(1, 3));
  EXPECT_TRUE(passes(two));
  Datagram jump = heartbeat(kFar + 2, kFar + 2);
  addSource(jump, 0x11);
  addSubmessagesOf(jump, heartbeat(1 + kFar, 4 + kFar));
  EXPECT_FALSE(passes(jump)) << "the second one's next sample is number 4";

  Datagram announced = heartbeat(1, 1);
  addSource(announced, 0x11);
  Datagram forged = announced;
  addSubmessagesOf(announced, announcement(10, 0x11));
  EXPECT_TRUE(passes(announced));
  addSubmessagesOf(forged, announcement(10));
  EXPECT_FALSE(passes(forged)) << "the first one's, in the second one's name";

  Datagram older = heartbeat(1, 1);
  addSource(older, 0x11, 1);
  EXPECT_FALSE(passes(older));
  Datagram cut = header();
  addSubmessage(cut, 0x0c, 0, Datagram(19));
  EXPECT_FALSE(passes(cut));
}

TEST(DatagramFilter, RefusesParametersBeyondTheEnd) {
  Datagram list{0x00, 0x03, 0x00, 0x00};
  add(list, 0x0005, 2);
  add(list, 400, 2);
  EXPECT_TRUE(passed(data(kPublicationsWriter, 1, list)).empty());
  EXPECT_FALSE(passed(data(kUserWriter, 1, list)).empty())
      << "a user's bytes mean nothing here";
}

TEST(DatagramFilter, RefusesFragmentsOfWhatCannotBe) {
  EXPECT_TRUE(passed(fragment(1, 1000, DatagramFilter::kLargestSample + 1, 1000)).empty());
  EXPECT_TRUE(passed(fragment(0, 1000, 2500, 1000)).empty());
  EXPECT_TRUE(passed(fragment(4, 1000, 2500, 1000)).empty());
  EXPECT_TRUE(passed(fragment(1, 0, 2500, 1000)).empty());
  EXPECT_TRUE(passed(fragment(1, 1000, 2500, 999)).empty());
}

TEST(DatagramFilter, HasAFirstQuestionAnsweredAtOnce) {
  EXPECT_EQ(passed(ackNack(kPublicationsWriter, 1, 0, false, 0)),
            ackNack(kPublicationsWriter, 0, 0, false, 1));
  const auto unchanged = [](std::uint32_t writer, std::int64_t base, std::uint32_t bits,
                            bool is_final) {
    EXPECT_EQ(passed(ackNack(writer, base, bits, is_final, 41)),
              ackNack(writer, base, bits, is_final, 42));
  };
  unchanged(kPublicationsWriter, 1, 0, true);
  unchanged(kPublicationsWriter, 2, 0, false);
  unchanged(kPublicationsWriter, 1, 3, false);
  unchanged(kUserWriter, 1, 0, false);
  unchanged(kUserWriter, 5, 40, false);
}

TEST(DatagramFilter, GivesEachParticipantItsShare) {
  DatagramFilter filter;
  const Datagram question = data(kUserWriter, 1, {0, 1, 0, 0, 1, 2, 3, 4});
  constexpr int kFlood = 20'000;
  const auto taken = [&](std::uint8_t who) {
    Datagram whose = question;
    whose[8] ^= who;
    int count = 0;
    for (int i = 0; i < kFlood; ++i)
      count += passed(filter, whose).empty() ? 0 : 1;
    return count;
  };
  const int first = taken(0);
  EXPECT_GE(first, static_cast<int>(DatagramFilter::kSharedAtOnce));
  EXPECT_LT(first, kFlood / 2);
  // What is left for others who flood is their own, and it is there.
  const int second = taken(1);
  EXPECT_GE(second, static_cast<int>(DatagramFilter::kSamplesAtOnce));
  EXPECT_LT(second, first / 2);
  Datagram anothers = question;
  anothers[8] ^= 2;
  EXPECT_FALSE(passed(filter, anothers).empty());
  // Who was held back is known, once.
  EXPECT_EQ(filter.takeOverShare().size(), 2u);
  EXPECT_TRUE(filter.takeOverShare().empty());
  // Discovery and what keeps streams whole are not held back.
  EXPECT_FALSE(passed(filter, announcement(20)).empty());
  EXPECT_FALSE(passed(filter, heartbeat(1, 7)).empty());
}

// === Before Cyclone DDS

Datagram passedToCyclone(const Datagram& datagram) {
  DatagramFilter filter(DatagramFilter::Domain::kOpen, DatagramFilter::Reader::kCyclone);
  return passed(filter, datagram);
}

Datagram typed(std::uint32_t writer, std::uint16_t parameter) {
  Datagram list{0x00, 0x03, 0x00, 0x00};
  add(list, parameter, 2);
  add(list, 4, 2);
  add(list, 0xffffffffU);
  add(list, 0x0001, 2);
  add(list, 0, 2);
  return data(writer, 1, list);
}

TEST(DatagramFilter, BlanksTypesBeforeCyclone) {
  constexpr std::uint16_t kTypeInformation = 0x0075;
  constexpr std::uint16_t kPadding = 0;
  EXPECT_EQ(passedToCyclone(typed(kPublicationsWriter, kTypeInformation)),
            typed(kPublicationsWriter, kPadding));
  EXPECT_EQ(passed(typed(kPublicationsWriter, kTypeInformation)),
            typed(kPublicationsWriter, kTypeInformation));
  // What is no list of parameters is left alone.
  EXPECT_EQ(passedToCyclone(typed(kUserWriter, kTypeInformation)),
            typed(kUserWriter, kTypeInformation));
}

TEST(DatagramFilter, CutsOutTheServiceOfTypesBeforeCyclone) {
  for (const std::uint32_t writer : {0x000300c3U, 0x000301c3U}) {
    EXPECT_TRUE(passedToCyclone(data(writer, 1, {0, 1, 0, 0, 1, 2, 3, 4})).empty());
    EXPECT_FALSE(passed(data(writer, 1, {0, 1, 0, 0, 1, 2, 3, 4})).empty());
  }
  EXPECT_FALSE(passedToCyclone(data(kUserWriter, 1, {0, 1, 0, 0, 1, 2, 3, 4})).empty());
}

TEST(DatagramFilter, TakesDiscoveryInWholeSamplesAloneBeforeCyclone) {
  Datagram piece = fragment(1, 100, 1000, 100);
  EXPECT_EQ(passedToCyclone(piece), piece);
  constexpr std::size_t kWriter = 20 + 4 + 8;
  piece[kWriter + 2] = 0x03;  // publications'
  piece[kWriter + 3] = 0xc2;
  EXPECT_TRUE(passedToCyclone(piece).empty());
}

/// An announcement of who calls itself so.
Datagram announcementOf(const std::string& name) {
  Datagram made = announcement(20);
  made.resize(made.size() - 4);  // its end
  Datagram text;
  add(text, static_cast<std::uint32_t>(name.size() + 1));
  text.insert(text.end(), name.begin(), name.end());
  text.resize((text.size() + 4) / 4 * 4);
  add(made, 0x0062, 2);
  add(made, static_cast<std::uint32_t>(text.size()), 2);
  made.insert(made.end(), text.begin(), text.end());
  add(made, 0x0001, 2);
  add(made, 0, 2);
  constexpr std::size_t kLengthAt = 20 + 2;
  const std::size_t length = made.size() - 24;
  made[kLengthAt] = static_cast<std::uint8_t>(length);
  made[kLengthAt + 1] = static_cast<std::uint8_t>(length >> 8);
  return made;
}

TEST(DatagramFilter, PassesOverClientsWhereThatIsWished) {
  const std::string client(DatagramFilter::kClient);
  for (const auto domain : {DatagramFilter::Domain::kOpen, DatagramFilter::Domain::kSecured}) {
    const auto is_passed = [domain](const std::string& name, bool are_passed_over) {
      DatagramFilter filter(domain, DatagramFilter::Reader::kCyclone);
      filter.passOverClients(are_passed_over);
      return !passed(filter, announcementOf(name)).empty();
    };
    EXPECT_TRUE(is_passed(client, false));
    EXPECT_FALSE(is_passed(client, true));
    for (const std::string& other :
         {std::string("handgraft-server"), client + "s", client.substr(1), std::string()})
      EXPECT_TRUE(is_passed(other, true)) << other;
  }
}

TEST(DatagramFilter, LooksAtKeysOfDiscoveryToo) {
  // DATA with a key in place of a sample, which is too short for one.
  Datagram cut = data(kPublicationsWriter, 1, {0, 3});
  cut[21] = 0x01 | 0x08;
  EXPECT_TRUE(passed(cut).empty());
  EXPECT_TRUE(passedToCyclone(cut).empty());
}

TEST(DatagramFilter, GivesOnlyWhatWouldPassAgain) {
  fuzz(DatagramFilter::Domain::kOpen,
       {heartbeat(1, 7), gap(3, 5), announcement(20),
        ackNack(kPublicationsWriter, 1, 40, false, 0), fragment(1, 100, 250, 100)});
}

}  // namespace
}  // namespace handgraft::idl
