// Datagrams made by hand, after OMG formal/2019-04-03 (RTPS 2.3), chapter 9.
#include "idl/datagrams/datagram_filter.h"

#include <cstring>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "idl/datagrams/shown_certificate.h"

namespace handgraft::idl {
namespace {

using Datagram = std::vector<std::uint8_t>;

constexpr std::uint32_t kParticipantWriter = 0x000100c2;
constexpr std::uint32_t kPublicationsWriter = 0x000003c2;
constexpr std::uint32_t kUserWriter = 0x00001203;

void add(Datagram& bytes, std::uint32_t number, int size = 4) {
  for (int i = 0; i < size; ++i)
    bytes.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
}

void addSequence(Datagram& bytes, std::int64_t number) {
  add(bytes, static_cast<std::uint32_t>(number >> 32));
  add(bytes, static_cast<std::uint32_t>(number));
}

/// In the wire's order.
void addEntity(Datagram& bytes, std::uint32_t entity) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(entity >> shift));
}

Datagram header() {
  Datagram bytes{'R', 'T', 'P', 'S', 2, 3, 1, 0x10};
  for (std::uint8_t i = 0; i < 12; ++i)
    bytes.push_back(static_cast<std::uint8_t>(0xa0 + i));
  return bytes;
}

void addSubmessage(Datagram& bytes,
                   std::uint8_t kind,
                   std::uint8_t flags,
                   const Datagram& body) {
  bytes.push_back(kind);
  bytes.push_back(static_cast<std::uint8_t>(flags | 1));
  add(bytes, static_cast<std::uint32_t>(body.size()), 2);
  bytes.insert(bytes.end(), body.begin(), body.end());
}

Datagram message(std::uint8_t kind, std::uint8_t flags, const Datagram& body) {
  Datagram bytes = header();
  addSubmessage(bytes, kind, flags, body);
  return bytes;
}

Datagram heartbeat(std::int64_t first, std::int64_t last) {
  Datagram body;
  addEntity(body, 0);
  addEntity(body, kUserWriter);
  addSequence(body, first);
  addSequence(body, last);
  add(body, 1);
  return message(0x07, 0, body);
}

Datagram ackNack(std::uint32_t writer,
                 std::int64_t base,
                 std::uint32_t bits,
                 bool is_final,
                 std::uint32_t count) {
  Datagram body;
  addEntity(body, 0x000003c7);
  addEntity(body, writer);
  addSequence(body, base);
  add(body, bits);
  for (std::uint32_t i = 0; i < (bits + 31) / 32; ++i)
    add(body, 0x80000000U);
  add(body, count);
  return message(0x06, is_final ? 2 : 0, body);
}

/// What a message says after its header is another participant's from here on.
void addSource(Datagram& bytes, std::uint8_t first_of_prefix, std::uint8_t major = 2) {
  Datagram body;
  add(body, 0);
  body.insert(body.end(), {major, 3, 1, 0x10, first_of_prefix});
  for (std::uint8_t i = 1; i < 12; ++i)
    body.push_back(static_cast<std::uint8_t>(0xa0 + i));
  addSubmessage(bytes, 0x0c, 0, body);
}

void addSubmessagesOf(Datagram& bytes, const Datagram& message) {
  bytes.insert(bytes.end(), message.begin() + 20, message.end());
}

Datagram gap(std::int64_t start, std::int64_t base) {
  Datagram body;
  addEntity(body, 0);
  addEntity(body, kUserWriter);
  addSequence(body, start);
  addSequence(body, base);
  add(body, 0);
  return message(0x08, 0, body);
}

Datagram data(std::uint32_t writer, std::int64_t number, const Datagram& payload) {
  Datagram body;
  add(body, 0, 2);
  add(body, 16, 2);
  addEntity(body, 0);
  addEntity(body, writer);
  addSequence(body, number);
  body.insert(body.end(), payload.begin(), payload.end());
  return message(0x15, 0x04, body);
}

Datagram announcement(std::uint32_t lease_s, std::uint8_t first_of_guid = 0xa0) {
  Datagram list{0x00, 0x03, 0x00, 0x00};
  add(list, 0x0050, 2);
  add(list, 16, 2);
  for (std::uint8_t i = 0; i < 12; ++i)
    list.push_back(static_cast<std::uint8_t>(i == 0 ? first_of_guid : 0xa0 + i));
  addEntity(list, 0x000001c1);
  add(list, 0x0002, 2);
  add(list, 8, 2);
  add(list, lease_s);
  add(list, 0);
  add(list, 0x0001, 2);
  add(list, 0, 2);
  return data(kParticipantWriter, 1, list);
}

Datagram fragment(std::uint32_t first,
                  std::uint32_t size,
                  std::uint32_t whole,
                  std::size_t given) {
  Datagram body;
  add(body, 0, 2);
  add(body, 28, 2);
  addEntity(body, 0);
  addEntity(body, kUserWriter);
  addSequence(body, 1);
  add(body, first);
  add(body, 1, 2);
  add(body, size, 2);
  add(body, whole);
  body.resize(body.size() + given);
  return message(0x16, 0, body);
}

Datagram passed(DatagramFilter& filter, const Datagram& datagram) {
  Datagram kept;
  const auto passed = filter.pass(datagram, kept);
  return {passed.begin(), passed.end()};
}

Datagram passed(const Datagram& datagram) {
  DatagramFilter filter;
  return passed(filter, datagram);
}

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
  EXPECT_FALSE(passed(announcement(DatagramFilter::kShortestLease_s)).empty());
  EXPECT_TRUE(passed(announcement(0)).empty());
  EXPECT_TRUE(passed(announcement(DatagramFilter::kShortestLease_s - 1)).empty());
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

// === In a secured domain

constexpr std::uint32_t kHandshakeWriter = 0x000201c3;

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
    const auto isPassed = [domain](const std::string& name, bool are_passed_over) {
      DatagramFilter filter(domain, DatagramFilter::Reader::kCyclone);
      filter.passOverClients(are_passed_over);
      return !passed(filter, announcementOf(name)).empty();
    };
    EXPECT_TRUE(isPassed(client, false));
    EXPECT_FALSE(isPassed(client, true));
    for (const std::string& other :
         {std::string("handgraft-server"), client + "s", client.substr(1), std::string()})
      EXPECT_TRUE(isPassed(other, true)) << other;
  }
}

TEST(DatagramFilter, LooksAtKeysOfDiscoveryToo) {
  // DATA with a key in place of a sample, which is too short for one.
  Datagram cut = data(kPublicationsWriter, 1, {0, 3});
  cut[21] = 0x01 | 0x08;
  EXPECT_TRUE(passed(cut).empty());
  EXPECT_TRUE(passedToCyclone(cut).empty());
}

Datagram passedSecured(const Datagram& datagram) {
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  return passed(filter, datagram);
}

void addText(Datagram& bytes, const std::string& text) {
  bytes.resize((bytes.size() + 3) / 4 * 4);
  add(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

/// A DataHolder: a class, one property, one binary property.
Datagram token(std::uint32_t count = 1) {
  Datagram bytes;
  addText(bytes, "DDS:Auth:PKI-DH:1.0+Req");
  for (int kind = 0; kind < 2; ++kind) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    add(bytes, count);
    addText(bytes, std::string("c.id\0", 5));
    addText(bytes, "what it is");
  }
  return bytes;
}

Datagram handshake(std::uint32_t count = 1, std::uint32_t properties = 1) {
  Datagram payload{0x00, 0x01, 0x00, 0x00};
  payload.resize(payload.size() + 24 + 24 + 16 + 16 + 16);
  addText(payload, "dds.sec.auth");
  payload.resize((payload.size() + 3) / 4 * 4);
  add(payload, count);
  const Datagram one = token(properties);
  payload.insert(payload.end(), one.begin(), one.end());
  return data(kHandshakeWriter, 1, payload);
}

/// As a participant with an identity announces itself.
Datagram securedAnnouncement(std::uint8_t name, const Datagram& identity = token()) {
  Datagram list{0x00, 0x03, 0x00, 0x00};
  add(list, 0x0050, 2);
  add(list, 16, 2);
  for (std::uint8_t i = 0; i < 12; ++i)
    list.push_back(static_cast<std::uint8_t>(0xa0 + i));
  addEntity(list, 0x000001c1);
  add(list, 0x0002, 2);
  add(list, 8, 2);
  add(list, 20);
  add(list, name);
  Datagram padded = identity;
  padded.resize((padded.size() + 3) / 4 * 4);
  add(list, 0x1001, 2);
  add(list, static_cast<std::uint32_t>(padded.size()), 2);
  list.insert(list.end(), padded.begin(), padded.end());
  add(list, 0x0001, 2);
  add(list, 0, 2);
  return data(kParticipantWriter, 1, list);
}

/// Prefix, body and postfix of one that is encrypted.
Datagram encrypted() {
  Datagram bytes = header();
  addSubmessage(bytes, 0x31, 0, Datagram(20, 0x77));
  addSubmessage(bytes, 0x30, 0, Datagram(64, 0x88));
  addSubmessage(bytes, 0x32, 0, Datagram(20, 0x99));
  return bytes;
}

TEST(SecuredDatagramFilter, PassesWhatIsEncryptedAndWhatMakesItSo) {
  for (const Datagram& sound : {encrypted(), securedAnnouncement(1), handshake()})
    EXPECT_EQ(passedSecured(sound), sound);
  Datagram several = header();
  addSubmessage(several, 0x0e, 0, Datagram(12, 1));
  addSubmessagesOf(several, encrypted());
  addSource(several, 0x11);
  addSubmessagesOf(several, encrypted());
  EXPECT_EQ(passedSecured(several), several);
}

/// `whole`, which holds one DATA, in pieces of so many bytes.
std::vector<Datagram> inPieces(const Datagram& whole, std::size_t size) {
  constexpr std::size_t kSample = 20 + 4 + 20;
  const Datagram sample(whole.begin() + kSample, whole.end());
  std::vector<Datagram> pieces;
  for (std::size_t at = 0; at < sample.size(); at += size) {
    const std::size_t given = std::min(size, sample.size() - at);
    Datagram piece =
        fragment(static_cast<std::uint32_t>(at / size + 1), static_cast<std::uint32_t>(size),
                 static_cast<std::uint32_t>(sample.size()), given);
    std::copy_n(whole.begin() + 20 + 4 + 4, 16, piece.begin() + 20 + 4 + 4);
    std::copy_n(sample.begin() + static_cast<std::ptrdiff_t>(at), given,
                piece.end() - static_cast<std::ptrdiff_t>(given));
    pieces.push_back(piece);
  }
  return pieces;
}

TEST(SecuredDatagramFilter, PutsHandshakesTogetherThatComeInFragments) {
  const Datagram whole = handshake();
  auto pieces = inPieces(whole, 40);
  ASSERT_GT(pieces.size(), 3u);
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    EXPECT_TRUE(passed(filter, pieces[i]).empty());
    EXPECT_TRUE(passed(filter, pieces[i]).empty()) << "said twice";
  }
  EXPECT_EQ(passed(filter, pieces[0]), whole);
  EXPECT_TRUE(passed(filter, pieces[0]).empty()) << "the first of another one";
  // What they make up is looked at as a whole one is.
  for (const Datagram& piece : inPieces(handshake(1, 0x10000000), 40))
    EXPECT_TRUE(passedSecured(piece).empty());
  DatagramFilter other(DatagramFilter::Domain::kSecured);
  for (const Datagram& piece : inPieces(handshake(0xffffffff), 40))
    EXPECT_TRUE(passed(other, piece).empty());
}

TEST(SecuredDatagramFilter, PutsNothingElseTogether) {
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  Datagram of_user = handshake();
  of_user[20 + 4 + 8 + 3] = 0x03;  // another writer
  for (const Datagram& piece : inPieces(of_user, 40))
    EXPECT_TRUE(passed(filter, piece).empty());
  Datagram large = handshake();
  large.resize(large.size() + SamplePieces::kLargest);
  for (const Datagram& piece : inPieces(large, 1000))
    EXPECT_TRUE(passed(filter, piece).empty());
}

TEST(SamplePieces, KeepsSoManyAndForgetsTheOldest) {
  SamplePieces pieces;
  const std::vector<std::uint8_t> bytes(10, 7);
  const auto half = [&](std::int64_t number, std::uint32_t first) {
    return pieces.add({{}, number, first, 10, 20, bytes});
  };
  for (std::int64_t number = 0; number < 65; ++number)
    EXPECT_FALSE(half(number, 1));
  EXPECT_EQ(half(64, 2), std::vector<std::uint8_t>(20, 7));
  EXPECT_FALSE(half(0, 2)) << "it gave way";
  EXPECT_FALSE(pieces.add({{}, 5, 2, 10, 30, bytes})) << "of another size than it began with";
  EXPECT_TRUE(half(5, 2));
}

TEST(SecuredDatagramFilter, PassesNothingOfWhoIsRefusedWhoeverBringsIt) {
  const auto beginOf = [](std::uint8_t first) {
    DatagramFilter::GuidBegin begin;
    for (std::uint8_t i = 0; i < begin.size(); ++i)
      begin[i] = static_cast<std::uint8_t>(first + i);
    return begin;
  };
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  std::vector<std::uint8_t> kept;
  ASSERT_FALSE(filter.pass(encrypted(), kept).empty());
  filter.refuse({beginOf(0xb0)});
  EXPECT_FALSE(filter.pass(encrypted(), kept).empty()) << "another one was refused";
  filter.refuse({beginOf(0xa0), beginOf(0xb0)});
  for (const Datagram& said : {encrypted(), securedAnnouncement(1), handshake()})
    EXPECT_TRUE(filter.pass(said, kept).empty());
  // What a participant brings for another one that is refused.
  DatagramFilter::GuidBegin other = beginOf(0xa0);
  other[0] = 0x11;
  filter.refuse({other});
  Datagram several = encrypted();
  EXPECT_FALSE(filter.pass(several, kept).empty());
  addSource(several, 0x11);
  addSubmessagesOf(several, encrypted());
  EXPECT_TRUE(filter.pass(several, kept).empty());
  filter.refuse({});
  EXPECT_FALSE(filter.pass(several, kept).empty());
}

TEST(SecuredDatagramFilter, TellsWhichCertificateAHandshakeShows) {
  std::vector<std::pair<DatagramFilter::GuidBegin, std::string>> told;
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  filter.tellCertificates([&](DatagramFilter::GuidBegin source, std::string_view shown) {
    told.emplace_back(source, shown);
  });
  std::vector<std::uint8_t> kept;
  filter.pass(handshake(), kept);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].first[0], 0xa0);
  EXPECT_EQ(told[0].second, "what it is");
  filter.pass(encrypted(), kept);
  filter.pass(handshake(100), kept);
  EXPECT_EQ(told.size(), 1U) << "of what is malformed";

  // Of any bytes it looks no further than their end.
  const std::vector<std::uint8_t> shown{'c', '.', 'i', 'd', 0,   0,   0,  0,
                                        3,   0,   0,   0,   'P', 'E', 'M'};
  EXPECT_EQ(shownCertificate(shown, true), "PEM");
  for (std::size_t size = 0; size < shown.size(); ++size)
    EXPECT_EQ(shownCertificate(std::span(shown).first(size), true), "");
  EXPECT_EQ(shownCertificate(shown, false), "");
}

TEST(SecuredDatagramFilter, CutsOutWhatIsPlain) {
  const Datagram sound = encrypted();
  for (const Datagram& plain :
       {heartbeat(1, 7), gap(3, 5), data(kUserWriter, 1, {0, 1, 0, 0, 42}),
        data(kPublicationsWriter, 1, {0, 3, 0, 0, 1, 0, 0, 0}), fragment(1, 1000, 2500, 1000),
        ackNack(kPublicationsWriter, 1, 0, false, 0), message(0x33, 0, Datagram(24))}) {
    EXPECT_TRUE(passedSecured(plain).empty());
    Datagram both = plain;
    addSubmessagesOf(both, sound);
    EXPECT_EQ(passedSecured(both), sound);
  }
  Datagram alone = header();
  addSubmessage(alone, 0x09, 0, Datagram(8));
  EXPECT_TRUE(passedSecured(alone).empty()) << "a time, of nothing";
}

TEST(SecuredDatagramFilter, WantsAllThreeOfWhatIsEncrypted) {
  const Datagram whole = encrypted();
  const std::ptrdiff_t body = 20 + 24;
  const std::ptrdiff_t postfix = body + 68;
  Datagram no_body(whole.begin(), whole.begin() + body);
  no_body.insert(no_body.end(), whole.begin() + postfix, whole.end());
  EXPECT_TRUE(passedSecured(no_body).empty());
  EXPECT_TRUE(passedSecured(Datagram(whole.begin(), whole.begin() + body)).empty());
  EXPECT_TRUE(passedSecured(Datagram(whole.begin(), whole.begin() + postfix)).empty());
  Datagram body_alone = header();
  body_alone.insert(body_alone.end(), whole.begin() + body, whole.end());
  EXPECT_TRUE(passedSecured(body_alone).empty());
}

TEST(SecuredDatagramFilter, LetsNobodyLeaveInTheClear) {
  Datagram disposal = announcement(20);
  disposal[21] = 0x01 | 0x08;  // its key alone
  EXPECT_TRUE(passedSecured(disposal).empty());
  // Status info 3, disposed and unregistered, in the inline QoS of a whole sample.
  Datagram body;
  add(body, 0, 2);
  add(body, 16, 2);
  addEntity(body, 0);
  addEntity(body, kParticipantWriter);
  addSequence(body, 1);
  add(body, 0x0071, 2);
  add(body, 4, 2);
  body.insert(body.end(), {0, 0, 0, 3});
  add(body, 0x0001, 2);
  add(body, 0, 2);
  const Datagram sound = announcement(20);
  body.insert(body.end(), sound.begin() + 44, sound.end());
  EXPECT_FALSE(passed(message(0x15, 0x06, body)).empty()) << "fine in an open domain";
  EXPECT_TRUE(passedSecured(message(0x15, 0x06, body)).empty());
}

TEST(SecuredDatagramFilter, HoldsParticipantsToTheirFirstWord) {
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  EXPECT_FALSE(passed(filter, securedAnnouncement(1)).empty());
  EXPECT_TRUE(passed(filter, securedAnnouncement(2)).empty());
  EXPECT_FALSE(passed(filter, securedAnnouncement(1)).empty());
  // A flood of others does not make it forget; they are not let in beyond the limit.
  std::size_t let_in = 0;
  for (std::uint32_t i = 0; i < 2 * DatagramFilter::kMostParticipants; ++i) {
    Datagram other = securedAnnouncement(1);
    for (std::size_t at : {std::size_t{16}, other.size()}) {
      // Its prefix: in the header, and in the parameter behind the header of DATA.
      const std::size_t place = at == 16 ? 16 : 20 + 4 + 20 + 4 + 4 + 8;
      std::memcpy(other.data() + place, &i, sizeof i);
    }
    if (!passed(filter, other).empty()) ++let_in;
  }
  EXPECT_EQ(let_in, DatagramFilter::kMostParticipants - 1);
  EXPECT_TRUE(passed(filter, securedAnnouncement(2)).empty());
  EXPECT_FALSE(passed(filter, securedAnnouncement(1)).empty());
}

TEST(SecuredDatagramFilter, RefusesTokensThatSayMoreThanTheyHold) {
  EXPECT_TRUE(passedSecured(handshake(5)).empty()) << "more tokens than there are";
  EXPECT_TRUE(passedSecured(handshake(0xffffffff)).empty());
  EXPECT_TRUE(passedSecured(handshake(1, 0x10000000)).empty());
  EXPECT_TRUE(passedSecured(securedAnnouncement(1, token(0x10000000))).empty());
  Datagram cut = token();
  cut.resize(20);
  EXPECT_TRUE(passedSecured(securedAnnouncement(1, cut)).empty());
}

/// Every cut, and a hundred thousand random changes: nothing beyond the end is read (ASan
/// looks), and what passes would pass again.
void fuzz(DatagramFilter::Domain domain, std::vector<Datagram> sound) {
  Datagram all = header();
  for (const Datagram& one : sound)
    all.insert(all.end(), one.begin() + 20, one.end());
  sound.push_back(all);
  std::mt19937 random(1);
  std::size_t through = 0;
  const auto check = [&](const Datagram& datagram) {
    DatagramFilter first(domain);
    const Datagram once = passed(first, datagram);
    if (once.empty()) return;
    ++through;
    DatagramFilter second(domain);
    ASSERT_EQ(passed(second, once).size(), once.size());
  };
  for (const Datagram& datagram : sound) {
    for (std::size_t size = 0; size <= datagram.size(); ++size)
      check(Datagram(datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(size)));
    for (int i = 0; i < 20'000; ++i) {
      Datagram damaged = datagram;
      for (unsigned n = 1 + random() % 4; n > 0; --n)
        damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
      check(damaged);
    }
  }
  EXPECT_GT(through, 1000U);
}

TEST(DatagramFilter, GivesOnlyWhatWouldPassAgain) {
  fuzz(DatagramFilter::Domain::kOpen,
       {heartbeat(1, 7), gap(3, 5), announcement(20),
        ackNack(kPublicationsWriter, 1, 40, false, 0), fragment(1, 100, 250, 100)});
}

TEST(SecuredDatagramFilter, GivesOnlyWhatWouldPassAgain) {
  fuzz(DatagramFilter::Domain::kSecured,
       {encrypted(), securedAnnouncement(1), handshake(), heartbeat(1, 7)});
}

}  // namespace
}  // namespace handgraft::idl
