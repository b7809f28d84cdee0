// A secured domain's part of the filter.
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "idl/datagrams/datagram_filter.h"
#include "idl/datagrams/shown_certificate.h"

#include "tests/idl/datagrams.h"

namespace handgraft::idl {
namespace {

using namespace test;

constexpr std::uint32_t kHandshakeWriter = 0x000201c3;

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
    addText(bytes, std::string(kind == 0 ? "what\0" : "c.id\0", 5));
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
  const auto begin_of = [](std::uint8_t first) {
    DatagramFilter::GuidBegin begin;
    for (std::uint8_t i = 0; i < begin.size(); ++i)
      begin[i] = static_cast<std::uint8_t>(first + i);
    return begin;
  };
  DatagramFilter filter(DatagramFilter::Domain::kSecured);
  std::vector<std::uint8_t> kept;
  ASSERT_FALSE(filter.pass(encrypted(), kept).empty());
  filter.refuse({begin_of(0xb0)});
  EXPECT_FALSE(filter.pass(encrypted(), kept).empty()) << "another one was refused";
  filter.refuse({begin_of(0xa0), begin_of(0xb0)});
  for (const Datagram& said : {encrypted(), securedAnnouncement(1), handshake()})
    EXPECT_TRUE(filter.pass(said, kept).empty());
  // What a participant brings for another one that is refused.
  DatagramFilter::GuidBegin other = begin_of(0xa0);
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
  bool is_ours = true;
  filter.askAboutCertificates([&](DatagramFilter::GuidBegin source, std::string_view shown) {
    told.emplace_back(source, shown);
    return is_ours;
  });
  std::vector<std::uint8_t> kept;
  EXPECT_FALSE(filter.pass(handshake(), kept).empty());
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].first[0], 0xa0);
  EXPECT_EQ(told[0].second, "what it is");
  filter.pass(encrypted(), kept);
  filter.pass(handshake(100), kept);
  EXPECT_EQ(told.size(), 1U) << "of what is malformed";
  is_ours = false;
  EXPECT_TRUE(filter.pass(handshake(), kept).empty()) << "a stranger's handshake";
  EXPECT_FALSE(filter.pass(encrypted(), kept).empty());

  // Of any bytes it looks no further than their end.
  const std::vector<std::uint8_t> shown{'c', '.', 'i', 'd', 0,   0,   0,  0,
                                        3,   0,   0,   0,   'P', 'E', 'M'};
  EXPECT_EQ(shownCertificate(shown, true), "PEM");
  for (std::size_t size = 0; size < 5; ++size)
    EXPECT_EQ(shownCertificate(std::span(shown).first(size), true), "");
  for (std::size_t size = 5; size < shown.size(); ++size)
    EXPECT_EQ(shownCertificate(std::span(shown).first(size), true), std::nullopt);
  EXPECT_EQ(shownCertificate(shown, false), std::nullopt);
  const std::vector<std::uint8_t> endless{4, 0, 0, 0, 'c', '.', 'i', 'd', 3, 0, 0, 0, 'P'};
  EXPECT_EQ(shownCertificate(endless, true), std::nullopt);
  std::vector<std::uint8_t> two = shown;
  two.insert(two.end(), shown.begin(), shown.end());
  EXPECT_EQ(shownCertificate(two, true), std::nullopt);
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

TEST(SecuredDatagramFilter, GivesOnlyWhatWouldPassAgain) {
  fuzz(DatagramFilter::Domain::kSecured,
       {encrypted(), securedAnnouncement(1), handshake(), heartbeat(1, 7)});
}

}  // namespace
}  // namespace handgraft::idl
