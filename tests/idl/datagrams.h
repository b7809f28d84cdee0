#pragma once

// Datagrams made by hand, after OMG formal/2019-04-03 (RTPS 2.3), chapter 9.
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "idl/datagrams/datagram_filter.h"

namespace handgraft::idl::test {

using Datagram = std::vector<std::uint8_t>;

inline constexpr std::uint32_t kParticipantWriter = 0x000100c2;
inline constexpr std::uint32_t kPublicationsWriter = 0x000003c2;
inline constexpr std::uint32_t kUserWriter = 0x00001203;

inline void add(Datagram& bytes, std::uint32_t number, int size = 4) {
  for (int i = 0; i < size; ++i)
    bytes.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
}

inline void addSequence(Datagram& bytes, std::int64_t number) {
  add(bytes, static_cast<std::uint32_t>(number >> 32));
  add(bytes, static_cast<std::uint32_t>(number));
}

/// In the wire's order.
inline void addEntity(Datagram& bytes, std::uint32_t entity) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(entity >> shift));
}

inline Datagram header() {
  Datagram bytes{'R', 'T', 'P', 'S', 2, 3, 1, 0x10};
  for (std::uint8_t i = 0; i < 12; ++i)
    bytes.push_back(static_cast<std::uint8_t>(0xa0 + i));
  return bytes;
}

inline void addSubmessage(Datagram& bytes,
                          std::uint8_t kind,
                          std::uint8_t flags,
                          const Datagram& body) {
  bytes.push_back(kind);
  bytes.push_back(static_cast<std::uint8_t>(flags | 1));
  add(bytes, static_cast<std::uint32_t>(body.size()), 2);
  bytes.insert(bytes.end(), body.begin(), body.end());
}

inline Datagram message(std::uint8_t kind, std::uint8_t flags, const Datagram& body) {
  Datagram bytes = header();
  addSubmessage(bytes, kind, flags, body);
  return bytes;
}

inline Datagram heartbeat(std::int64_t first, std::int64_t last) {
  Datagram body;
  addEntity(body, 0);
  addEntity(body, kUserWriter);
  addSequence(body, first);
  addSequence(body, last);
  add(body, 1);
  return message(0x07, 0, body);
}

inline Datagram ackNack(std::uint32_t writer,
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
inline void addSource(Datagram& bytes, std::uint8_t first_of_prefix, std::uint8_t major = 2) {
  Datagram body;
  add(body, 0);
  body.insert(body.end(), {major, 3, 1, 0x10, first_of_prefix});
  for (std::uint8_t i = 1; i < 12; ++i)
    body.push_back(static_cast<std::uint8_t>(0xa0 + i));
  addSubmessage(bytes, 0x0c, 0, body);
}

inline void addSubmessagesOf(Datagram& bytes, const Datagram& message) {
  bytes.insert(bytes.end(), message.begin() + 20, message.end());
}

inline Datagram gap(std::int64_t start, std::int64_t base) {
  Datagram body;
  addEntity(body, 0);
  addEntity(body, kUserWriter);
  addSequence(body, start);
  addSequence(body, base);
  add(body, 0);
  return message(0x08, 0, body);
}

inline Datagram data(std::uint32_t writer, std::int64_t number, const Datagram& payload) {
  Datagram body;
  add(body, 0, 2);
  add(body, 16, 2);
  addEntity(body, 0);
  addEntity(body, writer);
  addSequence(body, number);
  body.insert(body.end(), payload.begin(), payload.end());
  return message(0x15, 0x04, body);
}

inline Datagram announcement(std::uint32_t lease_s, std::uint8_t first_of_guid = 0xa0) {
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

inline Datagram fragment(std::uint32_t first,
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

inline Datagram passed(DatagramFilter& filter, const Datagram& datagram) {
  Datagram kept;
  const auto passed = filter.pass(datagram, kept);
  return {passed.begin(), passed.end()};
}

inline Datagram passed(const Datagram& datagram) {
  DatagramFilter filter;
  return passed(filter, datagram);
}

/// Every cut, and a hundred thousand random changes: nothing beyond the end is read (ASan
/// looks), and what passes would pass again.
inline void fuzz(DatagramFilter::Domain domain, std::vector<Datagram> sound) {
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

}  // namespace handgraft::idl::test
